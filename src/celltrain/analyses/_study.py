"""How the results of studies are shown; `celltrain sweep` computes them."""

from collections.abc import Mapping
from typing import NoReturn

from rich.console import Console

from celltrain.contract import Draw, Presentation
from celltrain.contract.status import ExitStatus
from celltrain.parameters import CaseError
from celltrain.results import Plain, plain
from celltrain.study import StudyResult
from celltrain.version import __version__


class StudyPresentation(Presentation[StudyResult]):
    """Tables and maps of a study."""

    result = StudyResult

    @classmethod
    def steady_train(cls, result: StudyResult) -> NoReturn:
        """There is none: a study's trains have files of their own.

        Raises:
            CaseError: always.
        """
        raise CaseError(
            "a study's dataset is not allowed as a start: it holds numbers only; allowed: the file"
            " of one of its cases, in the same folder"
        )

    @classmethod
    def report(cls, result: StudyResult, console: Console) -> None:
        """Print the table."""
        console.print(result.table(), end="", markup=False, highlight=False, soft_wrap=True)

    @classmethod
    def summary(cls, result: StudyResult) -> dict[str, Plain]:
        """The table's content by columns."""
        content = plain(result.data.to_dict(encoding=False))
        assert isinstance(content, dict)
        return {"version": __version__, "kind": result.kind, **content}

    @classmethod
    def pictures(cls, result: StudyResult) -> Mapping[str, Draw]:
        """Maps or curves of the main numbers."""
        from celltrain.pictures.study import study_pictures

        return study_pictures(result.data)

    @classmethod
    def status(cls, result: StudyResult) -> int:
        """3 if cases failed."""
        return ExitStatus.NOT_CONVERGED if result.failed else ExitStatus.DONE
