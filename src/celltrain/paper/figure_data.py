"""The data of a figure that is no study, in a file."""

from dataclasses import dataclass
from typing import ClassVar

from celltrain.results.labelled import Labelled


@dataclass(frozen=True, eq=False)
class FigureData(Labelled):
    """What a figure of the paper is drawn from; its attribute `figure` names it.

    `resolution` says whether it is converged or at the paper's degree.
    """

    kind: ClassVar[str] = "figure"
    title: ClassVar[str] = "data of a figure of Bryngelson & Freund (2018)"

    @property
    def figure(self) -> str:
        """The name of the figure, such as "fig3"."""
        return str(self.data.attrs["figure"])
