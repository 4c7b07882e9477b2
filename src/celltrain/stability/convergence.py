"""The spectral abscissa over the degree: how far to raise it, and what it leaves open.

The abscissa is looked at, not a mode: at another degree another mode may lead, and a train is as
unstable as its fastest one.
"""

from collections.abc import Callable, Sequence

import numpy as np

from celltrain.parameters import CaseError, Train
from celltrain.parameters.resolution import LARGEST_DEGREE, LEAST_DEGREE
from celltrain.stability.linearise import Blocks, linear_blocks
from celltrain.stability.neutral import neutral_space
from celltrain.stability.spectrum import growing_eigenvalues
from celltrain.steady import Base, NotConverged, steady
from celltrain.steady.base import IterationProgress
from celltrain.steady.degree import FEWEST, Convergence, higher, raised, remaining
from celltrain.steady.solve import at_degree
from celltrain.steady.ways import first_degree

#: Azimuthal numbers of the modes that matter in nearly all trains; others are added where they
#: lead.
NUMBERS = (0, 1, 2, 3)
#: Relative accuracy of growth rates unless told otherwise.
ACCURACY = 0.01
#: Per accuracy, the error in U/r0 that is small enough for any growth rate (1e-4 at the usual
#: accuracy), and the smallest that is stated.
SMALL_RATE, LEAST_ERROR = 1e-2, 1e-3
# What is left open at the highest degree, relative to the error that it is to tell.
KNOWN = 0.25

Tell = Callable[[str], None]


class AbscissaLadder:
    """Steady trains and spectral abscissas of one case at several degrees.

    **Arguments:** `case`: the case, or a steady train of it; `numbers`: azimuthal numbers to look
    at; `phases`: q in radians per cell, those of the train's N cells if not given; `start`: a
    steady train of another case to go on from.
    """

    def __init__(
        self,
        case: Train | Base,
        numbers: Sequence[int],
        phases: Sequence[float] | None = None,
        *,
        start: Base | None = None,
    ) -> None:
        self._start = start
        self._train = case.train if isinstance(case, Base) else case
        self._numbers = tuple(numbers)
        waves = range(self._train.cells // 2 + 1)
        own = tuple(2.0 * np.pi * j / self._train.cells for j in waves)
        self._phases = own if phases is None else tuple(phases)
        self._bases = {case.train.degree: case} if isinstance(case, Base) else {}
        self._found: dict[tuple[int, int], float] = {}
        self._blocks: dict[int, Blocks] = {}

    def base(self, degree: int, iteration: IterationProgress | None = None) -> Base:
        """The steady train at a degree.

        **Raises:** `NotConverged` or `CaseError` if there is none.
        """
        if degree not in self._bases:
            if self._bases:
                nearest = self._bases[min(self._bases, key=lambda each: abs(each - degree))]
                self._bases[degree] = at_degree(nearest, degree)
            else:
                train = self._train.changed(degree=degree)
                self._bases[degree] = steady(
                    train, start=self._start, estimate_error=False, progress=iteration
                )
        return self._bases[degree]

    def blocks(self, degree: int) -> Blocks:
        """The blocks at a degree that were needed so far, for all phases."""
        return self._blocks.get(degree, {})

    def abscissa(self, degree: int) -> float:
        """alpha at a degree."""
        return max(self.by_number(degree).values())

    def by_number(self, degree: int) -> dict[int, float]:
        """The largest growth rate of each azimuthal number that is looked at, at a degree."""
        return {m: self._of(degree, m) for m in self._numbers if m <= degree}

    def resolved(
        self,
        accuracy: float,
        *,
        estimate_error: bool,
        iteration: IterationProgress | None = None,
        tell: Tell | None = None,
    ) -> Convergence:
        """The degree to compute at: the case's own, or the first that is accurate enough.

        Of the case's own degree the error is estimated by higher ones, if asked for.

        **Raises:** `NotConverged` or `CaseError` if there is no steady train.
        """
        check_accuracy(accuracy)
        tell = _silent if tell is None else tell
        own = self._train.resolution.degree
        if own is not None:
            self.base(own, iteration)
            return self._with_error(own, accuracy, tell) if estimate_error else Convergence(own)

        def abscissa(degree: int) -> float:
            self.base(degree, iteration)
            value = self.abscissa(degree)
            tell(f"degree {degree}: largest growth rate {value:.6f} U/r0")
            return value

        return raised(
            abscissa,
            lambda found: accurate(found, accuracy),
            first=first_degree(self._train),
            least=LEAST_ERROR * accuracy,
        )

    def _with_error(self, degree: int, accuracy: float, tell: Tell) -> Convergence:
        """The abscissa at a degree and at higher ones, until these tell its error.

        At the highest degrees lower ones take their place.
        """
        degrees, values = [degree], [self.abscissa(degree)]
        for above in higher(degree):
            try:
                values.append(self.abscissa(above))
            except (NotConverged, CaseError):
                break
            tell(f"for the error, degree {above}: largest growth rate {values[-1]:.6f} U/r0")
            degrees.append(above)
            error = abs(values[0] - values[-1])
            if len(values) >= FEWEST and remaining(values) <= max(
                KNOWN * error, SMALL_RATE * accuracy
            ):
                break
        for below in (degree - 4, degree - 8):
            if len(values) < FEWEST and below >= LEAST_DEGREE:
                degrees.insert(0, below)
                values.insert(0, self.abscissa(below))
        return Convergence(degree, tuple(degrees), tuple(values), LEAST_ERROR * accuracy)

    def look_at(self, m: int) -> None:
        """Add an azimuthal number."""
        if m not in self._numbers:
            self._numbers = (*self._numbers, m)

    @property
    def numbers(self) -> tuple[int, ...]:
        """Azimuthal numbers that are looked at."""
        return self._numbers

    def _of(self, degree: int, m: int) -> float:
        if (degree, m) not in self._found:
            base = self.base(degree)
            missing = [n for n in self._numbers if n <= degree and (degree, n) not in self._found]
            made = linear_blocks(base, self._phases, missing)
            self._blocks.setdefault(degree, {}).update(made)
            for n, each in made.items():
                rates = (
                    growing_eigenvalues(block, neutral_space(base, n, 0 if q == 0.0 else 1))[0].real
                    for q, block in zip(self._phases, each, strict=True)
                )
                self._found[degree, n] = float(max(rates))
        return self._found[degree, m]


def accurate(convergence: Convergence, accuracy: float) -> bool:
    """Whether the last value is known to a relative accuracy, or to a small rate."""
    return convergence.left <= accuracy * max(abs(convergence.values[-1]), SMALL_RATE)


def check_accuracy(accuracy: float) -> None:
    """Check that an accuracy can be asked for.

    **Raises:** `CaseError` if not.
    """
    if not 1e-6 <= accuracy <= 1.0:
        raise CaseError(f"accuracy = {accuracy:g} is not allowed; allowed: 1e-06 to 1 (relative)")


def check_linearisable(train: Train, azimuthal_numbers: Sequence[int] | None) -> None:
    """Check that the linear dynamics of a train can be had, before anything is computed.

    A train that has no degree yet may get any, so its azimuthal numbers are held to the largest.

    **Raises:** `CaseError` for an azimuthal number out of range.
    """
    if azimuthal_numbers is None:
        return
    degree = train.resolution.degree
    most = LARGEST_DEGREE if degree is None else degree
    wrong = [m for m in azimuthal_numbers if not isinstance(m, int) or not 0 <= m <= most]
    if wrong or not azimuthal_numbers:
        given = ", ".join(str(m) for m in wrong) or "none"
        raise CaseError(
            f"azimuthal_numbers = {given} is not allowed; allowed: whole numbers from 0 to the"
            f" degree, {'at most ' if degree is None else ''}{most}"
        )


def _silent(_: str) -> None: ...
