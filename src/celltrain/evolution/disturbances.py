"""Disturbances of a steady train from which a simulation starts.

Each is a small object; its `shapes` are the change of all cells' coefficients, and its `amplitude`
is that of Eq. (8) of Bryngelson & Freund (2018), in r0, whatever the number of cells.
"""

import abc
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from celltrain.diagnostics import disturbance_amplitude
from celltrain.evolution.checks import check_positive
from celltrain.evolution.record.run import Run
from celltrain.harmonics import Shapes, displaced
from celltrain.parameters import CaseError
from celltrain.stability import Mode, Stability
from celltrain.steady import Base


class Disturbance(abc.ABC):
    """A change of the shapes of a steady train."""

    @abc.abstractmethod
    def shapes(self, start: Base | Stability) -> Shapes:
        """Change of the coefficients of all N cells, in r0.

        **Raises:** `CaseError` if the disturbance cannot be had from `start`.
        """

    def growth_rate(self, start: Base | Stability) -> float:
        """Growth rate (U/r0) that the linear theory predicts for late times, nan if unknown."""
        return start.spectral_abscissa if isinstance(start, Stability) else float("nan")


def _words(what: str, amplitude: float, phase: float = 0.0) -> str:
    turned = f", phase {phase:g}" if phase else ""
    return f"{what}, eps {amplitude:g} r0{turned}"


@dataclass(frozen=True)
class NumberedMode(Disturbance):
    """A mode of the linear dynamics, counted from 1 by falling growth rate, neutral ones left out.

    `phase` (radians) turns a complex mode in time.
    """

    number: int
    amplitude: float
    phase: float = 0.0

    def __post_init__(self) -> None:
        check_positive("amplitude", self.amplitude)
        if self.number < 1:
            raise CaseError(f"mode {self.number} is not allowed; allowed: a whole number >= 1")

    def __str__(self) -> str:
        return _words(f"mode {self.number}", self.amplitude, self.phase)

    def shapes(self, start: Base | Stability) -> Shapes:
        """The mode as a wave exp(i q p) along the cells p, real part."""
        found = self._mode(start)
        assert isinstance(start, Stability)
        return scaled(start.shape(found, self.phase), self.amplitude)

    def growth_rate(self, start: Base | Stability) -> float:
        """That of the mode."""
        return self._mode(start).growth_rate

    def _mode(self, start: Base | Stability) -> Mode:
        modes = [mode for mode in _analysed(start, "a mode").modes if not mode.neutral]
        if not 1 <= self.number <= len(modes):
            raise CaseError(
                f"mode {self.number} is not allowed; allowed: 1 to {len(modes)}, the modes of this"
                " train that are not neutral"
            )
        return modes[self.number - 1]


@dataclass(frozen=True)
class Leading(Disturbance):
    """The fastest growing mode, v_alpha."""

    amplitude: float
    phase: float = 0.0

    def __post_init__(self) -> None:
        check_positive("amplitude", self.amplitude)

    def __str__(self) -> str:
        return _words("the leading mode", self.amplitude, self.phase)

    def shapes(self, start: Base | Stability) -> Shapes:
        """Mode number 1."""
        return NumberedMode(1, self.amplitude, self.phase).shapes(start)

    def growth_rate(self, start: Base | Stability) -> float:
        """The spectral abscissa alpha."""
        return NumberedMode(1, self.amplitude).growth_rate(start)


@dataclass(frozen=True)
class FastestAtFirst(Disturbance):
    """The disturbance that grows fastest at first, v_eta, Eq. (15)."""

    amplitude: float
    phase: float = 0.0

    def __post_init__(self) -> None:
        check_positive("amplitude", self.amplitude)

    def __str__(self) -> str:
        return _words("what grows fastest at first", self.amplitude, self.phase)

    def shapes(self, start: Base | Stability) -> Shapes:
        """The optimal vector of the numerical abscissa in the paper's norm."""
        vector = _analysed(start, "the transient disturbance").transient_shape(self.phase)
        return scaled(vector, self.amplitude)


@dataclass(frozen=True)
class RandomDisplacement(Disturbance):
    """Each cell displaced as a rigid body, at random in each direction: the paper's "ad hoc" one.

    Displacements are normally distributed and then scaled to the amplitude; `seed` fixes them.
    """

    amplitude: float
    seed: int = 0

    def __post_init__(self) -> None:
        check_positive("amplitude", self.amplitude)

    def __str__(self) -> str:
        return _words(f"random displacements, seed {self.seed}", self.amplitude)

    def shapes(self, start: Base | Stability) -> Shapes:
        """Coefficients of Y_00 alone."""
        train = _base(start).train
        still = np.zeros((train.cells, 3, train.degree**2))
        random = np.random.default_rng(self.seed)
        return scaled(displaced(still, random.normal(size=(train.cells, 3))), self.amplitude)


@dataclass(frozen=True)
class FromFile(Disturbance):
    """What a file holds: the last shapes of another run of the same train, or a NumPy array.

    The array (`.npy`) holds the change of the coefficients, [cell, 3, coefficient], in r0. Without
    an amplitude it is taken as it is.
    """

    path: Path
    amplitude: float | None = None

    def __post_init__(self) -> None:
        if self.amplitude is not None:
            check_positive("amplitude", self.amplitude)

    def __str__(self) -> str:
        what = f"that of {self.path}"
        return what if self.amplitude is None else _words(what, self.amplitude)

    def shapes(self, start: Base | Stability) -> Shapes:
        """The array, or the last shapes less the steady ones."""
        train = _base(start).train
        wanted = (train.cells, 3, train.degree**2)
        try:
            if self.path.suffix == ".npy":
                change = np.load(self.path, allow_pickle=False)
            else:
                change = Run.load(self.path).disturbances[-1]
        except (OSError, ValueError) as error:
            raise CaseError(f"disturbance {str(self.path)!r} cannot be read: {error}") from None
        if change.shape != wanted or not np.isfinite(change).all() or not np.any(change):
            raise CaseError(
                f"disturbance {str(self.path)!r} has the shape {change.shape}; allowed: finite"
                f" numbers, not all zero, in the shape {wanted} of this train"
            )
        change = np.asarray(change, dtype=float)
        return change if self.amplitude is None else scaled(change, self.amplitude)


def scaled(shapes: Shapes, size: float) -> Shapes:
    """A disturbance with another amplitude."""
    return shapes * (size / disturbance_amplitude(shapes))


def _base(start: Base | Stability) -> Base:
    return start.base if isinstance(start, Stability) else start


def _analysed(start: Base | Stability, what: str) -> Stability:
    if not isinstance(start, Stability):
        raise CaseError(f"{what} is not known of a steady train alone: its stability is needed")
    return start
