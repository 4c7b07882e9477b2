"""The command for studies: ``celltrain sweep``."""

import json as json_
import sys
from contextlib import redirect_stdout
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from celltrain.cli.arguments import Json, Quiet
from celltrain.cli.compute import NOT_KEPT, Request, keep, keep_text
from celltrain.cli.study_run import Count, Retry, Scheduler, StudyRun, compute
from celltrain.contract import presentation
from celltrain.study import collect, read_study

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
    """Run or resume a study: the stability of trains over ranges of their parameters.

    Exit status 3 if cases failed; the table says why.
    """
    wanted = read_study(study)
    folder = output or Path(study.stem)
    run = StudyRun(folder, workers, scheduler, retry, quiet)
    errors = Console(stderr=True)
    # Only the result itself may go to standard output.
    with redirect_stdout(sys.stderr):
        records = compute(wanted, run, errors)
    result = collect(wanted, records)
    text = result.table()
    if json:
        print(json_.dumps([record.model_dump() for record in records.values()], indent=2))
    else:
        sys.stdout.write(text)
    kept = keep(result, Request(output=folder / "study.nc", plot=folder, quiet=quiet), errors)
    kept &= keep_text(text, folder / "table.md", errors, quiet=quiet)
    return presentation(result.kind).status(result) or (0 if kept else NOT_KEPT)
