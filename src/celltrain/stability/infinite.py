"""Trains without end: growth rates of waves of any length, and the most unstable one.

A disturbance exp(i q p) of an infinite train, p the number of the cell, has the block A_m(q) of
`linear_blocks` with any real q, computed from one cell. A train of N cells with periodic ends has q
= 2 pi j/N only, so its eigenvalues lie on the infinite train's curves alpha_m(q). A_m(-q) is the
complex conjugate of A_m(q): 0 <= q <= pi is all.

q = 0 is special in two ways. There the flow rate is held by the mean flow. This makes no
difference: a wave with q > 0 carries no flux, since the flux is the same at all z; A_m(q) - A_m(0)
vanishes as q does (`distance_to_uniform`; at D = 6, packing 0.2, M = 12: 0.005 q, 0.025 q, 0.004 q,
0.0005 q of |A_m(0)| for m = 0 ... 3). And there, only, the train's displacement is a neutral mode
that is set aside. For small q it is a wave of the cells' spacing with an eigenvalue close to 0
(-3.5e-4 q^2 + 0.0012 i q in the same case): alpha_0(q) goes to 0 with q, alpha_0(0) is the next
mode's. So an infinite train is never better than marginal: if nothing grows, the most unstable wave
is the longest one looked at, q = 0.001.

The growth rate's maximum is sought about the best samples, by bounded optimisation of the exact
alpha_m(q).
"""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
import scipy  # loads its parts when they are used
from jaxtyping import Complex, Float

from celltrain.parameters import CaseError, Train
from celltrain.quantities import Quantity, Record
from celltrain.stability.convergence import (
    ACCURACY,
    NUMBERS,
    AbscissaLadder,
    Tell,
    check_linearisable,
)
from celltrain.stability.coordinates import normed_block
from celltrain.stability.linearise import LinearDynamics, Progress, linear_blocks, smallest
from celltrain.stability.neutral import NeutralSpace, neutral_space
from celltrain.stability.norms import Norm, PaperNorm
from celltrain.stability.spectrum import block_spectrum
from celltrain.steady import Base
from celltrain.steady.base import IterationProgress
from celltrain.steady.degree import Convergence
from celltrain.steady.solve import with_velocity_error

SAMPLES = 17
#: Smallest phase but 0 for which the dynamics is accurate.
SMALLEST = 1e-3
# Local maxima of the samples about which the most unstable wave is sought, and its tolerance.
MOST_PEAKS = 3
PHASE_TOLERANCE = 1e-5

Phases = Float[np.ndarray, " phase"]


@dataclass(frozen=True, eq=False)
class WaveMode(Record):
    """The fastest growing mode of A_m(q), neutral modes set aside; q in radians per cell.

    `right` and `left` are its vectors in `azimuthal_basis(degree, m)`, left^H right = 1.
    """

    growth_rate: Annotated[
        float, Quantity(r"\alpha_m(q)", "U/r0", "largest growth rate, neutral modes set aside")
    ]
    frequency: Annotated[float, Quantity(r"\omega_m(q)", "U/r0", "frequency of the same mode")]
    azimuthal_number: Annotated[int, Quantity("m", "1", "azimuthal number of the mode")]
    phase: Annotated[float, Quantity("q", "rad", "phase of the mode from cell to cell")]
    right: Annotated[
        Complex[np.ndarray, " size"],
        Quantity("v", "1", "right vector of the mode", ("row",), bulky=True),
    ]
    left: Annotated[
        Complex[np.ndarray, " size"],
        Quantity("w", "1", "left vector of the mode", ("row",), bulky=True),
    ]


@dataclass(frozen=True, eq=False)
class InfiniteTrain(Record):
    """The linear dynamics of an infinite train at the phases q, rates in U/r0.

    `leading` holds for each m one mode for each q; `numerical_abscissas` for each m the largest
    initial growth rates in the norm (see `coordinates` for what it does about neutral modes).
    `most_unstable` is the best of all q, by optimisation, not of the samples only;
    `error_estimate` the error of the largest growth rate by `convergence`, that rate at several
    degrees (NaN, and empty, if that was not asked for).
    """

    kind: ClassVar[str] = "infinite"
    title: ClassVar[str] = "linear dynamics of an infinite train of cells in a tube"

    base: Base
    norm: Annotated[str, Quantity("", "1", "norm of disturbances")]
    phases: Annotated[Phases, Quantity("q", "rad", "phases from cell to cell")]
    leading: Annotated[
        dict[int, tuple[WaveMode, ...]], Quantity("", "1", "the leading mode at each phase")
    ]
    numerical_abscissas: Annotated[
        dict[int, Phases],
        Quantity(r"\eta_m(q)", "U/r0", "largest initial growth rate in the norm", ("phase",)),
    ]
    most_unstable: WaveMode
    error_estimate: Annotated[
        float,
        Quantity(
            r"\delta\alpha",
            "U/r0",
            "error of the largest growth rate by what its changes with the degree leave",
        ),
    ]
    convergence: Convergence
    seconds: Annotated[dict[str, float], Quantity("", "s", "wall time of each stage")]

    @property
    def azimuthal_numbers(self) -> tuple[int, ...]:
        """Those that were looked at."""
        return tuple(self.leading)

    def growth_rates(self, m: int) -> Phases:
        """alpha_m(q) at the phases."""
        return np.array([mode.growth_rate for mode in self.leading[m]])

    def frequencies(self, m: int) -> Phases:
        """Imaginary part of the leading eigenvalue of A_m(q); the phase moves at -this/q."""
        return np.array([mode.frequency for mode in self.leading[m]])


def infinite_train(
    case: Train | Base,
    *,
    start: Base | None = None,
    phases: Sequence[float] | Phases | None = None,
    azimuthal_numbers: Sequence[int] = NUMBERS,
    norm: Norm | None = None,
    accuracy: float = ACCURACY,
    estimate_error: bool = True,
    search: bool = True,
    progress: Progress | None = None,
    iteration: IterationProgress | None = None,
    tell: Tell | None = None,
) -> InfiniteTrain:
    """Growth rates of an infinite train over the phase q, and the most unstable wave.

        alpha_m(q) = max Re lambda, lambda the eigenvalues of A_m(q), neutral ones set aside.

    **Arguments:**

    - `case`: a case or a steady train of it; the number of cells does not matter. The degree of a
      case that has none rises as in `stability`.
    - `phases`: q in radians per cell, rising, 0 or from 0.001 to pi; 17 in equal steps from 0
      to pi if not given.
    - `azimuthal_numbers`: m, each from 0 to the degree.
    - `norm`: of eta_m(q); that of the paper, Eq. (8), if not given.
    - `start`, `accuracy`, `estimate_error`, `iteration`, `tell`: as for `stability`; the error is
      that of the largest growth rate at the phases looked at.
    - `search`: for the most unstable wave between the phases, too; otherwise it is one of theirs.
    - `progress`: called with (azimuthal numbers done, all).

    **Returns:** an `InfiniteTrain`.

    **Raises:** `CaseError` for phases or azimuthal numbers that are not allowed; `NotConverged` if
    there is no steady train.
    """
    begin = time.perf_counter()
    numbers = tuple(azimuthal_numbers)
    check_linearisable(case if isinstance(case, Train) else case.train, numbers)
    samples = np.linspace(0.0, np.pi, SAMPLES) if phases is None else np.array(phases)
    check_phases(samples)
    norm = PaperNorm() if norm is None else norm
    ladder = AbscissaLadder(case, numbers, [float(q) for q in samples], start=start)
    convergence = ladder.resolved(
        accuracy, estimate_error=estimate_error, iteration=iteration, tell=tell
    )
    base = ladder.base(convergence.degree)
    if math.isnan(base.velocity_error):
        base = with_velocity_error(base)
    dynamics = LinearDynamics(
        base, largest_azimuthal_number=max(numbers), smallest_phase=smallest(samples)
    )
    blocks = {}
    for done, m in enumerate(numbers, 1):
        blocks[m] = dynamics.blocks(m, samples)
        if progress is not None:
            progress(done, len(numbers))
    leading = {
        m: tuple(_leading(base, m, float(q), blocks[m][i]) for i, q in enumerate(samples))
        for m in numbers
    }
    abscissas = {
        m: np.array(
            [
                normed_block(block, gram, _neutral(base, m, q)).numerical_abscissa
                for q, block in zip(samples, blocks[m], strict=True)
            ]
        )
        for m, gram in norm.grams(base.coefficients, numbers).items()
    }
    best = max((mode for each in leading.values() for mode in each), key=lambda w: w.growth_rate)
    if search:
        best = _most_unstable(dynamics, samples, leading, best)
    return InfiniteTrain(
        base=base,
        norm=norm.name,
        phases=samples,
        leading=leading,
        numerical_abscissas=abscissas,
        most_unstable=best,
        error_estimate=convergence.error,
        convergence=convergence,
        seconds={**base.seconds, "total": time.perf_counter() - begin},
    )


def distance_to_uniform(
    base: Base,
    phases: Sequence[float],
    azimuthal_numbers: Sequence[int] = NUMBERS,
) -> dict[int, Phases]:
    """|A_m(q) - A_m(0)|/|A_m(0)|, 2-norms, for each m and each q (radians per cell)."""
    places = np.array([0.0, *phases])
    blocks = linear_blocks(base, places, azimuthal_numbers)
    return {
        m: np.linalg.norm(each[1:] - each[0], 2, axis=(1, 2)) / np.linalg.norm(each[0], 2)
        for m, each in blocks.items()
    }


def check_phases(phases: Phases) -> None:
    """Check that phases rise, and are 0 or from 0.001 to pi.

    **Raises:** `CaseError` if they do not.
    """
    if phases.ndim != 1 or len(phases) == 0:
        raise CaseError("phases = none is not allowed; allowed: numbers from 0 to pi")
    wrong = phases[~((phases == 0.0) | ((phases >= SMALLEST) & (phases <= np.pi)))]
    if wrong.size:
        raise CaseError(
            f"phases = {wrong[0]:g} is not allowed; allowed: 0, and from {SMALLEST:g} to pi"
        )
    if (np.diff(phases) <= 0.0).any():
        raise CaseError("phases that do not rise are not allowed")


def _neutral(base: Base, m: int, q: float) -> NeutralSpace:
    return neutral_space(base, m, 0 if q == 0.0 else 1)


def _leading(base: Base, m: int, q: float, block: Complex[np.ndarray, "size size"]) -> WaveMode:
    spectrum = block_spectrum(block, _neutral(base, m, q))
    index = spectrum.kinds.index("")
    value = spectrum.eigenvalues[index]
    return WaveMode(
        float(value.real),
        float(value.imag),
        m,
        q,
        spectrum.right[:, index],
        spectrum.left[:, index],
    )


def _most_unstable(
    dynamics: LinearDynamics,
    samples: Phases,
    leading: dict[int, tuple[WaveMode, ...]],
    best: WaveMode,
) -> WaveMode:
    """The fastest growing mode of all phases, by a search about the best samples."""
    peaks = []
    for m, modes in leading.items():
        rates = np.array([mode.growth_rate for mode in modes])
        padded = np.concatenate([[-np.inf], rates, [-np.inf]])
        peaks += [
            (rates[i], m, i)
            for i in range(len(rates))
            if padded[i] <= rates[i] >= padded[i + 2] and len(rates) > 1
        ]
    for _, m, place in sorted(peaks, reverse=True)[:MOST_PEAKS]:
        low = max(float(samples[max(place - 1, 0)]), SMALLEST)
        high = float(samples[min(place + 1, len(samples) - 1)])

        def mode(q: float, m: int = m) -> WaveMode:
            return _leading(dynamics.base, m, q, dynamics.blocks(m, [q])[0])

        found = scipy.optimize.minimize_scalar(
            lambda q: -mode(float(q)).growth_rate,
            bounds=(low, high),
            method="bounded",
            options={"xatol": PHASE_TOLERANCE},
        )
        best = max(best, mode(float(found.x)), key=lambda each: each.growth_rate)
    return best
