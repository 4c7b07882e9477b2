"""What the commands that analyse a steady train further have in common."""

import json
import sys
from collections.abc import Callable, Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from rich.console import Console

from celltrain.cli.compute import Request, describe_failure, read_start, read_train
from celltrain.cli.outputs import check_folder, check_output
from celltrain.cli.progress import Reporter
from celltrain.parameters import Train, read_case
from celltrain.results import replace_file
from celltrain.steady import Base, NotConverged

if TYPE_CHECKING:
    import xarray

Result = TypeVar("Result")


@dataclass(frozen=True)
class Analysis(Generic[Result]):
    """What is done with a case, and with what comes of it.

    `check` looks at the case before anything is computed; `compute` takes the case and the steady
    train to start from, if there is one; `save` is there if there is an output.
    `change` makes of the case that was given the one to begin with.
    """

    check: Callable[[Train], None]
    compute: Callable[[Train, Base | None, Reporter], Result]
    summary: Callable[[Result], dict[str, Any]]
    report: Callable[[Result, Console], None]
    plot: Callable[[Result, Path], list[Path]]
    save: Callable[[Result, Path], None] | None = None
    change: Callable[[Train], Train] = lambda train: train


def analyse(request: Request, leaves: Mapping[str, Any], analysis: Analysis[Result]) -> int:
    """Compute what is asked for, keep and show it; return the exit status.

    Raises:
        CaseError: for anything in the request that is not allowed, before computing.
    """
    case = read_case(request.case) if request.case else None
    start = read_start(request.start) if request.start else None
    train = analysis.change(read_train(case, start, leaves))
    analysis.check(train)
    if request.output:
        check_output(request.output)
    if request.plot:
        check_folder(request.plot)
    errors = Console(stderr=True)
    # Only the result itself may go to standard output.
    with redirect_stdout(sys.stderr), Reporter(errors, quiet=request.quiet) as reporter:
        try:
            result = analysis.compute(train, start, reporter)
        except NotConverged as failure:
            return describe_failure(failure, errors, request.output)
        if request.output and analysis.save:
            analysis.save(result, request.output)
            reporter.log(f"saved {request.output}")
        if request.plot:
            for path in analysis.plot(result, request.plot):
                reporter.log(f"drew {path}")
    if request.json:
        print(json.dumps(analysis.summary(result), indent=2, allow_nan=False))
    else:
        analysis.report(result, Console())
    return 0


def save_dataset(data: "xarray.Dataset", path: Path) -> None:
    """Write a data set as netCDF; a file that cannot be written leaves the old one as it was.

    Raises:
        OSError: if the file cannot be written.
    """
    replace_file(path, lambda part: data.to_netcdf(part, engine="h5netcdf"))
