"""The paper's figures, and what it says about them beside what is found."""

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import xarray as xr

from celltrain.analyses._figure import figure_summary
from celltrain.contract import Crew, InFolder, Kept, Setting, load, presentation
from celltrain.paper import FIGURES, PaperFigure, findings_table, paper_study
from celltrain.paper.figure_data import FigureData
from celltrain.paper.resolutions import CONVERGED, PAPER, Resolutions
from celltrain.paper.trains import PAPER_DEGREE
from celltrain.parameters import CaseError
from celltrain.quantities import Record
from celltrain.results import read
from celltrain.results.labelled import Labelled
from celltrain.study import compute_study

if TYPE_CHECKING:
    Name = str
else:
    Name = Literal[tuple(FIGURES)]
DATA = "study.nc"


@dataclass(frozen=True, kw_only=True)
class Paper(InFolder):
    """Compute or resume one of the paper's figures, draw it, and check the paper's statements.

    Exit status 3 if cases failed. A statement that does not hold is a result, no failure.
    """

    argument = "figure"

    figure: Annotated[Name, Setting("Figure of the paper, or its table.")]
    quick: Annotated[
        bool, Setting("Of a map or curve, a coarse grid at a low degree: the pattern.")
    ] = False
    resolution: Annotated[
        Literal["converged", "paper"],
        Setting(
            "Converged to one per cent, or degree 12 as in the paper. Where results of the other"
            " one lie in its folder, the picture shows both."
        ),
    ] = "converged"

    @property
    def _figure(self) -> PaperFigure:
        return FIGURES[self.figure]

    @property
    def _degree(self) -> int | None:
        return PAPER_DEGREE if self.resolution == PAPER else None

    @property
    def _folders(self) -> dict[str, Path]:
        """The usual folder for each resolution, which figures of one study share."""
        name = f"paper-{self._figure.study}"
        return {CONVERGED: Path(name), PAPER: Path(f"{name}-degree-{PAPER_DEGREE}")}

    @property
    def folder(self) -> Path:
        """paper-STUDY, with -quick or -degree-12; figures of one study share it."""
        converged = self._folders[CONVERGED]
        return Path(f"{converged}-quick") if self.quick else self._folders[self.resolution]

    def check(self) -> None:
        """Look at the settings.

        Raises:
            CaseError: if a quick one is asked for that there is not.
        """
        if self.quick and (self.resolution == PAPER or self._figure.compute is not None):
            where = "resolution = 'paper'" if self.resolution == PAPER else self.figure
            raise CaseError(f"quick is not allowed with {where}; allowed: maps and curves")

    def compute(self, folder: Path, crew: Crew) -> Kept:
        """Compute what the folder does not hold of the figure's data.

        Raises:
            CaseError, ComputationFailed, KeyboardInterrupt: as `Crew`.
        """
        chosen = self._figure
        result, results, texts = self._result(folder, crew)
        findings = chosen.findings(result.data)
        text = findings_table(findings)
        if self.quick:
            degrees = result.data["taken_degree"].values
            text += f"\nBy a coarse grid at M = {degrees.max():.0f}: the pattern, not the claims.\n"
        both: Resolutions = {self.resolution: result.data}
        if folder == self.folder and not self.quick:
            both |= self._beside()
        return Kept(
            text,
            figure_summary(self.figure, findings),
            {**texts, f"{self.figure}.md": text},
            results,
            lambda: {self.figure: partial(chosen.draw, both)},
            presentation(result.kind).status(result),
            f"without {chosen.needs}" if chosen.needs else "",
        )

    def _result(
        self, folder: Path, crew: Crew
    ) -> tuple[Labelled, dict[str, Record], dict[str, str]]:
        """The data of the figure, and what is to be written of them."""
        figure = self._figure
        if figure.compute is None:
            study = paper_study(figure, quick=self.quick, degree=self._degree)
            result = compute_study(study, folder, crew)
            return result, {DATA: result}, {"table.md": result.table()}
        if (folder / DATA).is_file() and not crew.retry:
            return read(folder / DATA, FigureData), {}, {}
        data: xr.Dataset = figure.compute(self._degree)
        data = data.assign_attrs(figure=self.figure, resolution=self.resolution)
        return FigureData(data), {DATA: FigureData(data)}, {}

    def _beside(self) -> Resolutions:
        """The data of the other resolution, if they lie in its folder."""
        [(other, folder)] = (each for each in self._folders.items() if each[0] != self.resolution)
        found = load(folder / DATA) if (folder / DATA).is_file() else None
        return {other: found.data} if isinstance(found, Labelled) else {}
