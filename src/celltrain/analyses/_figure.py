"""How figures of the paper that are no studies are shown; `celltrain paper` computes them."""

from collections.abc import Mapping, Sequence
from typing import NoReturn

from rich.console import Console

from celltrain.contract import Draw, Presentation
from celltrain.paper import FIGURES, Finding, findings_table
from celltrain.paper.figure_data import FigureData
from celltrain.parameters import CaseError
from celltrain.results import Plain, plain
from celltrain.version import __version__


class FigurePresentation(Presentation[FigureData]):
    """The picture of a figure, and the paper's statements about it."""

    result = FigureData

    @classmethod
    def steady_train(cls, result: FigureData) -> NoReturn:
        """There is none: a figure's data are numbers.

        Raises:
            CaseError: always.
        """
        raise CaseError("a figure's data are not allowed as a start: they hold numbers only")

    @classmethod
    def report(cls, result: FigureData, console: Console) -> None:
        """Print the statements beside what was found."""
        text = findings_table(FIGURES[result.figure].findings(result.data))
        console.print(text, end="", markup=False, highlight=False, soft_wrap=True)

    @classmethod
    def summary(cls, result: FigureData) -> dict[str, Plain]:
        """The statements beside what was found."""
        return figure_summary(result.figure, FIGURES[result.figure].findings(result.data))

    @classmethod
    def pictures(cls, result: FigureData) -> Mapping[str, Draw]:
        """The figure."""
        both = {str(result.data.attrs["resolution"]): result.data}
        return {result.figure: lambda: FIGURES[result.figure].draw(both)}


def figure_summary(figure: str, findings: Sequence[Finding]) -> dict[str, Plain]:
    """Statements of the paper on a figure beside what was found, as JSON can hold them."""
    return {
        "version": __version__,
        "kind": FigureData.kind,
        "figure": figure,
        "findings": [plain(vars(finding)) for finding in findings],
    }
