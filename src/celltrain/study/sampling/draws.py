"""What is computed of a train of a sample, and from where its steady shape is sought.

All trains of a sample are near the central one, the train of the means. So a shape is first
guessed: with z_i the place of the i-th parameter in its distribution, in deviations of a normal
one, and d the displacement of the steady shape from the shape at rest,

    d(z) = d(0) + sum_i [(d(+h e_i) - d(-h e_i))/(2 h) z_i
                         + (d(+h e_i) + d(-h e_i) - 2 d(0))/(2 h^2) z_i^2],

and then corrected by Newton's method; z = 0 are the means. The guess follows from the study alone,
never from what happens to be finished, so a train's numbers are the same whenever it is computed.
"""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Float

from celltrain.harmonics import Profile, coefficients_of
from celltrain.parameters import CaseError, Train
from celltrain.quantities import Quantity, numbers, quantities
from celltrain.stability import ACCURACY, Mode, Stability
from celltrain.stability.convergence import AbscissaLadder
from celltrain.steady import Base, NotConverged, steady
from celltrain.steady.problem import SteadyProblem

#: Place of the trains from which shapes are guessed, in deviations.
STEP = 1.5
# Guesses farther out would be extrapolated too far.
FARTHEST = 3.0

_OF_BASE = ("cell_velocity", "effective_viscosity", "gap", "largest_radius")
_CHECKS = ("residual", "truncation_error")
#: What the distribution is reported of.
OUTPUTS: dict[str, Quantity] = {
    "spectral_abscissa": quantities(Stability)["spectral_abscissa"],
    **{name: numbers(Base)[name] for name in _OF_BASE},
}
#: Numbers of every train of a sample, by name.
COLUMNS: dict[str, Quantity] = {
    **OUTPUTS,
    "leading_azimuthal_number": quantities(Mode)["azimuthal_number"],
    "error_estimate": quantities(Stability)["error_estimate"],
    **{name: numbers(Base)[name] for name in _CHECKS},
    "processor_seconds": Quantity("", "s", "processor time that a train took"),
}


@dataclass(frozen=True)
class DrawRecord:
    """What came of a train of a sample: its numbers by name, or why there are none."""

    status: Literal["finished", "failed"]
    reason: str
    values: dict[str, float]


@dataclass(frozen=True, eq=False)
class Guess:
    """Steady shapes about the central train, from which those of others are guessed.

    `first` and `second` are the derivatives of the displacements by the scores; they are zero for a
    parameter along which a neighbour was not found.
    """

    central: Base
    first: Float[np.ndarray, "parameter 2 degree"]
    second: Float[np.ndarray, "parameter 2 degree"]

    def base(self, train: Train, scores: Sequence[float]) -> Base:
        """The guess for a train of the same degree, in the form of a steady train.

        **Raises:** `CaseError` if there is no shape at rest.
        """
        z = np.clip(np.asarray(scores), -FARTHEST, FARTHEST)
        moved = displacement(self.central)
        moved = moved + np.tensordot(z, self.first, 1) + 0.5 * np.tensordot(z**2, self.second, 1)
        profile = SteadyProblem(train).rest + moved
        return replace(self.central, train=train, coefficients=coefficients_of(profile))


def make_guess(central: Base, neighbours: Sequence[tuple[Profile | None, Profile | None]]) -> Guess:
    """A guess from displacements at -`STEP` and +`STEP` along each parameter; None: not found."""
    here = displacement(central)
    first, second = np.zeros((2, len(neighbours), *here.shape))
    for i, (below, above) in enumerate(neighbours):
        if below is not None and above is not None:
            first[i] = (above - below) / (2.0 * STEP)
            second[i] = (above + below - 2.0 * here) / STEP**2
    return Guess(central, first, second)


def displacement(base: Base) -> Profile:
    """The displacement of a steady shape from that at rest."""
    return base.profile - SteadyProblem(base.train).rest


def neighbour(train: Train, central: Base) -> Profile | None:
    """The displacement of a train from rest, continued from the central one; None if not found."""
    try:
        return displacement(steady(train, start=central, estimate_error=False))
    except (NotConverged, CaseError):
        return None


@dataclass(frozen=True)
class DrawJob:
    """Trains that a worker computes one after another, with their scores and checks."""

    trains: tuple[Train, ...]
    scores: tuple[tuple[float, ...], ...]
    checked: tuple[bool, ...]
    azimuthal_numbers: tuple[int, ...]

    def __call__(self, guess: Guess) -> list[DrawRecord]:
        """The records of the trains; whatever a train raises is its failure."""
        found = []
        for train, scores, checked in zip(self.trains, self.scores, self.checked, strict=True):
            try:
                values = self._numbers(train, guess.base(train, scores), checked=checked)
                found.append(DrawRecord("finished", "", values))
            except Exception as error:
                found.append(DrawRecord("failed", f"{type(error).__name__}: {error}", {}))
        return found

    def _numbers(self, train: Train, start: Base, *, checked: bool) -> dict[str, float]:
        begin = time.process_time()
        base = steady(train, start=start, estimate_error=False)
        ladder = AbscissaLadder(base, self.azimuthal_numbers)
        rates = ladder.by_number(train.degree)
        seconds = time.process_time() - begin
        leading = max(rates, key=lambda m: rates[m])
        error = ladder.resolved(ACCURACY, estimate_error=True).error if checked else math.nan
        return {
            "spectral_abscissa": rates[leading],
            **{name: float(getattr(base, name)) for name in (*_OF_BASE, *_CHECKS)},
            "leading_azimuthal_number": float(leading),
            "error_estimate": error,
            "processor_seconds": seconds,
        }
