"""The command for the paper's figures: ``celltrain paper``."""

import json as json_
import sys
from collections.abc import Callable
from contextlib import redirect_stdout
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import xarray as xr
from cyclopts import Parameter

from celltrain.cli.arguments import Json, Quiet
from celltrain.cli.keeping import Keeper, say
from celltrain.cli.outputs import check_folder
from celltrain.cli.study_run import Count, Retry, Scheduler, StudyRun, compute
from celltrain.contract import load
from celltrain.contract.drawing import draw_file
from celltrain.contract.status import ExitStatus
from celltrain.paper import FIGURES, findings_table, paper_study
from celltrain.paper.figure_data import FigureData
from celltrain.paper.resolutions import CONVERGED, PAPER, Resolutions
from celltrain.paper.trains import PAPER_DEGREE
from celltrain.parameters import CaseError
from celltrain.results import only_writer, read, replace_file, save
from celltrain.results.labelled import Labelled
from celltrain.study import collect

Write = Callable[[Path], object]

if TYPE_CHECKING:
    Name = str
else:
    Name = Literal[tuple(FIGURES)]
FigureName = Annotated[Name, Parameter(help="Figure of the paper, or its table.")]
Quick = Annotated[
    bool,
    Parameter(help="Of a map or curve, a coarse grid at a low degree: the pattern.", negative=()),
]
Resolution = Annotated[
    Literal["converged", "paper"],
    Parameter(
        help="Converged to one per cent, or degree 12 as in the paper. Where results of the other"
        " one lie in its folder, the picture shows both."
    ),
]
Folder = Annotated[
    Path | None,
    Parameter(
        name=("--output", "-o"),
        help="Folder for the results, made if it is not there; paper-STUDY unless given, with"
        " -quick or -degree-12, which figures of one study share. What it holds already is not"
        " computed again.",
    ),
]


def paper(
    figure: FigureName,
    /,
    *,
    quick: Quick = False,
    resolution: Resolution = "converged",
    output: Folder = None,
    workers: Count = None,
    scheduler: Scheduler = None,
    retry: Retry = False,
    json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Compute or resume one of the paper's figures, draw it, and check the paper's statements.

    Exit status 3 if cases failed. A statement that does not hold is a result, no failure.
    """
    chosen = FIGURES[figure]
    if quick and (resolution == PAPER or chosen.compute is not None):
        where = "resolution = 'paper'" if resolution == PAPER else figure
        raise CaseError(f"quick is not allowed with {where}; allowed: maps and curves")
    degree = PAPER_DEGREE if resolution == PAPER else None
    usual = {CONVERGED: f"paper-{chosen.study}", PAPER: f"paper-{chosen.study}-degree-12"}
    folder = output or Path(f"{usual[CONVERGED]}-quick" if quick else usual[resolution])
    run = StudyRun(folder, workers, scheduler, retry, quiet)
    check_folder(folder, "output")
    with only_writer(folder):
        # Only the result itself may go to standard output.
        with redirect_stdout(sys.stderr):
            data, files, failed = _data(figure, run, quick=quick, degree=degree)
            findings = chosen.findings(data)
        text = findings_table(findings)
        shown = text
        if json:
            shown = json_.dumps([asdict(finding) for finding in findings], indent=2) + "\n"
        keeper = Keeper(quiet=quiet)
        keeper.show(lambda: sys.stdout.write(shown))
        for path, write in files.items():
            keeper.file(path, write)
        keeper.text(folder / f"{figure}.md", text)
        both: Resolutions = {resolution: data}
        if output is None and not quick:
            both |= _beside(resolution, usual)
        keeper.picture(folder / f"{figure}.png", partial(draw_file, lambda: chosen.draw(both)))
        if chosen.needs and not quiet:
            say(f"without {chosen.needs}")
        return ExitStatus.NOT_CONVERGED if failed else keeper.status


def _beside(resolution: str, folders: dict[str, str]) -> Resolutions:
    """The data of the other resolution, if they lie in its folder."""
    [other] = set(folders) - {resolution}
    path = Path(folders[other]) / "study.nc"
    if not path.is_file():
        return {}
    found = load(path)
    return {other: found.data} if isinstance(found, Labelled) else {}


def _data(
    name: str, run: StudyRun, *, quick: bool, degree: int | None
) -> tuple[xr.Dataset, dict[Path, Write], bool]:
    """The data of a figure, how to write the files with it, and whether a case failed."""
    path, figure = run.folder / "study.nc", FIGURES[name]
    if figure.compute is not None:
        if path.is_file() and not run.retry:
            return read(path, FigureData).data, {}, False
        resolution = CONVERGED if degree is None else PAPER
        data = figure.compute(degree).assign_attrs(figure=name, resolution=resolution)
        return data, {path: partial(save, FigureData(data))}, False
    study = paper_study(figure, quick=quick, degree=degree)
    records = compute(study, run)
    result = collect(study, records)
    table = result.table()

    def write(path: Path) -> None:
        replace_file(path, lambda part: part.write_text(table, encoding="utf-8"))

    files: dict[Path, Write] = {path: partial(save, result), run.folder / "table.md": write}
    return result.data, files, any(record.status == "failed" for record in records.values())
