"""The command for the paper's figures: ``celltrain paper``."""

import json as json_
import sys
from contextlib import redirect_stdout
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Annotated, Literal

import xarray as xr
from cyclopts import Parameter
from rich.console import Console

from celltrain.cli.arguments import Json, Quiet
from celltrain.cli.compute import NOT_CONVERGED
from celltrain.cli.outputs import check_folder
from celltrain.cli.study_run import Count, Retry, Run, Scheduler, compute
from celltrain.paper import FIGURES, PaperFigure, findings_table, paper_study
from celltrain.paper.figures import PAPER_DEGREE
from celltrain.parameters import CaseError
from celltrain.results import replace_file, save, write_dataset
from celltrain.study import collect

FigureName = Annotated[
    Literal["fig6", "fig8", "fig13", "fig14", "fig16", "fig17", "fig19"],
    Parameter(help="Figure of the paper."),
]
Quick = Annotated[
    bool, Parameter(help="A coarse grid at a low degree: the pattern in minutes.", negative=())
]
Resolution = Annotated[
    Literal["converged", "paper"],
    Parameter(
        help="Converged to one per cent, or degree 12 as in the paper (a fifth of the time)."
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
    if quick and resolution == "paper":
        raise CaseError("resolution = 'paper' is not allowed with quick, which has its own degree")
    degree = PAPER_DEGREE if resolution == "paper" else None
    ending = "-quick" if quick else "" if degree is None else f"-degree-{degree}"
    folder = output or Path(f"paper-{chosen.study}{ending}")
    run = Run(folder, workers, scheduler, retry, quiet)
    errors = Console(stderr=True)
    # Only the result itself may go to standard output.
    with redirect_stdout(sys.stderr):
        data, written, failed = _data(chosen, run, errors, quick=quick, degree=degree)
        findings = chosen.findings(data)
        text = findings_table(findings)
        written.append(_write(text, folder / f"{figure}.md"))
        written.append(chosen.draw(data, folder / f"{figure}.png"))
        if not quiet:
            for path in written:
                errors.print(f"wrote {path}", highlight=False, markup=False, soft_wrap=True)
    if json:
        print(json_.dumps([asdict(finding) for finding in findings], indent=2))
    else:
        sys.stdout.write(text)
    return NOT_CONVERGED if failed else 0


def _data(
    figure: PaperFigure, run: Run, errors: Console, *, quick: bool, degree: int | None
) -> tuple[xr.Dataset, list[Path], bool]:
    """The data of a figure, the files with it, and whether a case failed."""
    if figure.compute is not None:
        check_folder(run.folder, "output")
        data = figure.compute(quick)
        return data, [write_dataset(data, run.folder / "shapes.nc")], False
    study = paper_study(figure, quick=quick, degree=degree)
    records = compute(study, run, errors)
    result = collect(study, records)
    written = [
        save(result, run.folder / "study.nc"),
        _write(result.table(), run.folder / "table.md"),
    ]
    return result.data, written, any(record.status == "failed" for record in records.values())


def _write(text: str, path: Path) -> Path:
    replace_file(path, partial(Path.write_text, data=text))
    return path
