"""What computes many cases into a folder, where it goes on when it is repeated."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar, Protocol, TypeVar, runtime_checkable

from celltrain.contract.analysis import Draw
from celltrain.quantities import Record
from celltrain.results import Plain

Found = TypeVar("Found")


@runtime_checkable
class Crew(Protocol):
    """Workers, and what shows how far they are."""

    @property
    def retry(self) -> bool:
        """Whether what failed before is computed again."""

    def __call__(
        self, run: Callable[..., Found], title: str, total: int, *, many: bool = False
    ) -> Found:
        """What `run` returns when it is given an executor, slots, `retry` and `progress`.

        `total` is the number of its cases; of `many` of them only failures have lines of their own.

        Raises:
            ComputationFailed: if it could not go on, with what is kept.
            KeyboardInterrupt: with what is kept as the message.
        """


@dataclass(frozen=True)
class Kept:
    """What there is when all is computed.

    Attributes:
        report: what people read, on standard output.
        summary: the same for programs, as JSON.
        texts, results: what is written, by its name in the folder.
        pictures: gives what is drawn, by its name without ending.
        status: exit status of the command.
        remark: what is to be said besides; nothing if it is empty.
    """

    report: str
    summary: Plain
    texts: Mapping[str, str]
    results: Mapping[str, Record]
    pictures: Callable[[], Mapping[str, Draw]] = field(default=dict)
    status: int = 0
    remark: str = ""


class InFolder(ABC):
    """A computation of many cases; the fields of a subclass, a frozen dataclass, are its settings.

    Its command has the name of its file, and as help the first line of its docstring.
    """

    #: The field that is the command's argument; all others are options.
    argument: ClassVar[str]

    @abstractmethod
    def check(self) -> None:
        """Look at the settings before anything is computed.

        Raises:
            CaseError: for what is not allowed.
        """

    @property
    @abstractmethod
    def folder(self) -> Path:
        """Where the results go unless another folder is named."""

    @abstractmethod
    def compute(self, folder: Path, crew: Crew) -> Kept:
        """Compute what the folder, which is there, does not hold.

        Raises:
            CaseError: for what turns out not to be allowed.
            ComputationFailed, KeyboardInterrupt: as `Crew`.
        """
