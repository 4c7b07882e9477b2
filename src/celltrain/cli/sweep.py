"""The command for studies: ``celltrain sweep``."""

import json as json_
import sys
from contextlib import redirect_stdout
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from celltrain.cli.arguments import Json, Quiet
from celltrain.cli.keeping import Keeper
from celltrain.cli.outputs import check_folder
from celltrain.cli.study_run import Count, Retry, Scheduler, StudyRun, compute, compute_sample
from celltrain.contract import presentation
from celltrain.results import only_writer
from celltrain.study import (
    SampledStudy,
    SampleResult,
    Study,
    StudyResult,
    collect,
    collect_sample,
    read_study,
)

StudyFile = Annotated[Path, Parameter(help="TOML file of the study.")]
Folder = Annotated[
    Path | None,
    Parameter(
        name=("--output", "-o"),
        help="Folder for the results, made if it is not there; named after the study file unless"
        " given. What it holds already is not computed again.",
    ),
]


def sweep(
    study: StudyFile,
    /,
    *,
    output: Folder = None,
    workers: Count = None,
    scheduler: Scheduler = None,
    retry: Retry = False,
    json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Run or resume a study: trains over ranges or distributions of parameters.

    Exit status 3 if cases failed; the table says why.
    """
    wanted = read_study(study)
    folder = output or Path(study.stem)
    run = StudyRun(folder, workers, scheduler, retry, quiet)
    check_folder(folder, "output")
    with only_writer(folder):
        return _sweep(wanted, run, json=json)


def _sweep(wanted: Study | SampledStudy, run: StudyRun, *, json: bool) -> int:
    result: StudyResult | SampleResult
    # Only the result itself may go to standard output.
    with redirect_stdout(sys.stderr):
        if isinstance(wanted, SampledStudy):
            result = collect_sample(wanted, compute_sample(wanted, run))
            plain: object = presentation(result.kind).summary(result)
        else:
            records = compute(wanted, run)
            result = collect(wanted, records)
            plain = [each.model_dump() for each in records.values()]
    text = result.table()
    shown = json_.dumps(plain, indent=2) + "\n" if json else text
    keeper = Keeper(quiet=run.quiet)
    keeper.show(lambda: sys.stdout.write(shown))
    keeper.text(run.folder / "table.md", text)
    keeper.result(result, run.folder / "study.nc", run.folder)
    return presentation(result.kind).status(result) or keeper.status
