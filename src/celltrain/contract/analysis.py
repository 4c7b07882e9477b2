"""What an analysis is."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar, Generic, TypeAlias, TypeVar

from rich.console import Console

from celltrain.contract.progress import Progress
from celltrain.parameters import Scales, Train
from celltrain.quantities import Record
from celltrain.results import Plain, summary
from celltrain.stability import (
    ACCURACY,
    Stability,
    check_accuracy,
    check_linearisable,
    stability,
)
from celltrain.steady import Base

if TYPE_CHECKING:
    from matplotlib.figure import Figure  # takes a good part of a second

Result = TypeVar("Result", bound=Record)
#: Draws one picture.
Draw: TypeAlias = Callable[[], "Figure"]


@dataclass(frozen=True)
class Setting:
    """What a field of an analysis sets: `help` of its option, and the values it may have.

    `option` is the option's name where that of the field is not good, without dashes.
    """

    help: str
    allowed: str = ""
    option: str = ""


class Presentation(ABC, Generic[Result]):
    """How results of one kind are shown and kept, whether just computed or read from a file."""

    #: The class of the results.
    result: ClassVar[type[Record]]

    @classmethod
    def steady_train(cls, result: Result) -> Base:
        """The steady train in a result, from which others may start.

        Raises:
            CaseError: if it holds none.
        """
        base: Base = result.base  # type: ignore[attr-defined]
        return base

    @classmethod
    @abstractmethod
    def report(cls, result: Result, console: Console) -> None:
        """Print what people want to know."""

    @classmethod
    def summary(cls, result: Result) -> dict[str, Plain]:
        """The same for programs, as JSON can hold it."""
        return summary(result)

    @classmethod
    def pictures(cls, result: Result) -> Mapping[str, Draw]:
        """How its pictures are drawn, by their names."""
        return {}

    @classmethod
    def files(cls, result: Result, path: Path) -> Mapping[Path, Record]:
        """What is saved under which path when a result is to be saved as `path`."""
        return {path: result}

    @classmethod
    def status(cls, result: Result) -> int:
        """Exit status of the command."""
        return 0

    @classmethod
    def remark(cls, result: Result, path: Path | None) -> str:
        """What is to be said of a result that is not whole, and of its file; nothing otherwise."""
        return ""


class Analysis(Presentation[Result]):
    """One computation on a case; the fields of a subclass, a frozen dataclass, are its settings.

    The first line of a subclass' docstring is the help of its command, whose name is that of its
    file and of its results' kind, unless it has a `command`.
    """

    #: The name of its command, where that of its file is not good: a constant.
    command: ClassVar[str] = ""

    def leaves(self) -> Mapping[str, object]:
        """Leaves of the case that settings give, in the units of the case."""
        return {}

    def dimensionless(self, scales: Scales) -> "Analysis[Result]":
        """These settings with values in r0, U and mu, where they were given in SI."""
        return self

    def check(self, train: Train) -> None:
        """Look at case and settings before anything is computed.

        Raises:
            CaseError: for what is not allowed.
        """

    @abstractmethod
    def compute(self, train: Train, start: Base | None, progress: Progress) -> Result:
        """Compute the result, from a steady train that is known, if there is one.

        Raises:
            CaseError: for what turns out not to be allowed.
            NotConverged: if there is no steady train.
        """


@dataclass(frozen=True, kw_only=True)
class WrittenMeanwhile(Analysis[Result]):
    """An analysis that writes its file while it computes, and can go on with it later."""

    resume: Annotated[bool, Setting("Go on with what is in the output file.")] = False
    overwrite: Annotated[bool, Setting("Replace the output file.")] = False

    def compute(self, train: Train, start: Base | None, progress: Progress) -> Result:
        """Compute the result without a file.

        Raises:
            CaseError, NotConverged: as `compute_into`.
        """
        return self.compute_into(train, start, progress, None)

    @abstractmethod
    def compute_into(
        self, train: Train, start: Base | Stability | None, progress: Progress, path: Path | None
    ) -> Result:
        """Compute the result, and write what is known of it into a file again and again.

        Raises:
            CaseError: for what turns out not to be allowed.
            NotConverged: if there is no steady train.
        """

    @abstractmethod
    def go_on(self, path: Path, progress: Progress) -> Result:
        """Go on with what is in a file.

        Raises:
            CaseError: for what is not allowed.
        """


Accuracy = Annotated[
    float,
    Setting(
        "Relative accuracy of the growth rate at which the degree stops rising, where none is"
        " given; an accuracy of 1e-4 U/r0 is always enough."
    ),
]
Numbers = Annotated[
    Sequence[int] | None,
    Setting(
        "Azimuthal numbers m to compute, such as 0 1 2; unless given, all that matter.",
        "whole numbers from 0 to the degree",
    ),
]


@dataclass(frozen=True, kw_only=True)
class OfDynamics(Analysis[Result]):
    """An analysis with linear dynamics: of which azimuthal numbers, and how exactly."""

    azimuthal_numbers: Numbers = None
    accuracy: Accuracy = ACCURACY

    def check(self, train: Train) -> None:
        """Look at case and settings before anything is computed.

        Raises:
            CaseError: for what is not allowed.
        """
        check_linearisable(train, self.azimuthal_numbers)
        check_accuracy(self.accuracy)


@dataclass(frozen=True, kw_only=True)
class OfStability(OfDynamics[Result]):
    """An analysis that goes on from the linear dynamics of a train of N cells.

    Studies may compute it for each of their cases.
    """

    def compute(self, train: Train, start: Base | None, progress: Progress) -> Result:
        """Compute the linear dynamics, and go on from it.

        Raises:
            CaseError: for what turns out not to be allowed.
            NotConverged: if there is no steady train.
        """
        dynamics = stability(
            train,
            start=start,
            accuracy=self.accuracy,
            azimuthal_numbers=self.azimuthal_numbers,
            estimate_error=False,
            progress=progress.share,
            iteration=progress.iteration,
            tell=progress.log,
        )
        return self.of(dynamics, progress)

    @abstractmethod
    def of(self, dynamics: Stability, progress: Progress) -> Result:
        """The result, from the linear dynamics.

        Raises:
            CaseError: for what turns out not to be allowed.
        """
