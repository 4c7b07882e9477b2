"""One train at several degrees: the numbers at the highest, and what they leave open."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from celltrain import Base, Stability, Train, stability, steady
from celltrain.stability import PaperNorm, normed_blocks
from celltrain.stability.convergence import ACCURACY, LEAST_ERROR
from celltrain.steady.degree import Convergence

#: The paper's degree.
PAPER = 12
#: Degrees whose growth rates tell the error at the last of them, at which pages compute.
LADDER = (PAPER, 16, 20, 24)
FINE = LADDER[-1]


@dataclass(frozen=True)
class Converged:
    """A train at the degree `FINE`, at the paper's degree, and the error of the former's alpha."""

    fine: Stability
    paper: Stability
    error: float


def bases(train: Train, start: Base | None = None) -> dict[int, Base]:
    """The steady train at each degree of `LADDER`; `start` is one of another case."""
    found: dict[int, Base] = {}
    for degree in LADDER:
        start = steady(train.changed(degree=degree), start=start, estimate_error=False)
        found[degree] = start
    return found


def converged(trains: dict[int, Base], numbers: Sequence[int]) -> Converged:
    """The linear dynamics at all degrees; the error by the package's own rule."""
    results = {
        degree: stability(base, azimuthal_numbers=numbers, estimate_error=False)
        for degree, base in trains.items()
    }
    rates = tuple(each.spectral_abscissa for each in results.values())
    left = Convergence(FINE, tuple(results), rates, LEAST_ERROR * ACCURACY)
    return Converged(results[FINE], results[PAPER], left.error)


def with_ratio(trains: dict[int, Base], ratio: float) -> dict[int, Base]:
    """The same steady trains, which do not depend on it, with another viscosity ratio."""
    return {
        degree: replace(base, train=base.train.changed(viscosity_ratio=ratio))
        for degree, base in trains.items()
    }


def eta_of_fixed_volume(result: Stability) -> float:
    """Numerical abscissa in the paper's norm of disturbances that change no cell's volume, U/r0."""
    return max(each.numerical_abscissa for each in normed_blocks(result, PaperNorm()).values())
