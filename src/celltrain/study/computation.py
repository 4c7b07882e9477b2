"""What is done with each case of a study: its steady train, and the stability of that."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from celltrain.contract import Silent
from celltrain.parameters import CaseError, Train
from celltrain.stability import Stability, stability
from celltrain.steady import Base, NotConverged
from celltrain.study.columns import COLUMNS, further, further_analysis
from celltrain.study.definition import Computed


@dataclass(frozen=True)
class Outcome:
    """What comes of a case: the steady train, to go on from, and numbers.

    `values` are by the names of their columns (see `columns`).
    """

    base: Base
    values: dict[str, float]


class Computation(Protocol):
    """What is computed of a case; it travels to the workers."""

    @property
    def settings(self) -> dict[str, object]:
        """What is computed, in what JSON can hold; other settings make other results."""

    def __call__(self, train: Train, start: Base | None) -> Outcome:
        """Compute a case, perhaps from another one's steady train.

        Any exception is the case's failure, its message the reason.
        """


@dataclass(frozen=True)
class StabilityOfCase:
    """The steady train and its linear stability; the degree rises where a case has none."""

    computed: Computed

    @property
    def settings(self) -> dict[str, object]:
        """See `Computation`."""
        return self.computed.model_dump()

    def __call__(self, train: Train, start: Base | None) -> Outcome:
        """See `Computation`.

        **Raises:** `NotConverged` or `CaseError` if no steady train was found.
        """
        result = self._stability(train, start)
        return Outcome(result.base, values_of(result, self.computed.analyses))

    def _stability(self, train: Train, start: Base | None) -> Stability:
        """From where the study says, or else from the other place."""
        first, second = (None, start) if self.computed.start == "rest" else (start, None)
        computed = self.computed

        def analysed(start: Base | None) -> Stability:
            return stability(
                train,
                start=start,
                azimuthal_numbers=computed.azimuthal_numbers,
                estimate_error=computed.estimate_error,
            )

        try:
            return analysed(first)
        except (NotConverged, CaseError):
            if start is None:
                raise
            return analysed(second)


def values_of(result: Stability, analyses: Sequence[str] = ()) -> dict[str, float]:
    """The numbers of a case by the names of their columns, those of further analyses included."""
    values = {name: float(column.of(result)) for name, column in COLUMNS.items()}
    for name in analyses:
        found = further_analysis(name).of(result, Silent())
        values |= {each: float(column.of(found)) for each, column in further([name]).items()}
    return values
