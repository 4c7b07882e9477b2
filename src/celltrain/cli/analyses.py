"""What the commands that analyse a steady train further have in common."""

import json
import sys
from collections.abc import Callable, Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Generic, TypeVar

from cyclopts import Parameter
from rich.console import Console

from celltrain.cli.compute import Request, _not_converged, _start, _train
from celltrain.cli.options import reader
from celltrain.cli.outputs import check_folder, check_output
from celltrain.cli.progress import Reporter
from celltrain.parameters import Train, read_case
from celltrain.steady import Base, NotConverged, steady

CaseFile = Annotated[Path | None, Parameter(help="TOML file of the case; options override it.")]
Json = Annotated[bool, Parameter(help="Print one JSON object and nothing else.", negative=())]
Quiet = Annotated[bool, Parameter(help="No progress on standard error.", negative=())]
Plot = Annotated[Path | None, Parameter(help="Folder for pictures; made if it is not there.")]
Start = Annotated[
    Path | None,
    Parameter(
        help="netCDF file with a result to continue from; without a case file, its case is the"
        " one that the options change."
    ),
]
Numbers = Annotated[
    list[int] | None,
    Parameter(
        consume_multiple=True,
        negative=(),
        converter=reader(int, "allowed: whole numbers from 0 to the degree"),
        help="Azimuthal numbers m to compute, such as 0 1 2.",
    ),
]

Result = TypeVar("Result")


@dataclass(frozen=True)
class Analysis(Generic[Result]):
    """What is done with a steady train, and with what comes of it.

    `check` looks at the case before anything is computed; `save` is there if there is an output.
    """

    check: Callable[[Train], None]
    compute: Callable[[Base, Reporter], Result]
    summary: Callable[[Result], dict[str, Any]]
    report: Callable[[Result, Console], None]
    plot: Callable[[Result, Path], list[Path]]
    save: Callable[[Result, Path], None] | None = None


def analyse(request: Request, leaves: Mapping[str, Any], analysis: Analysis[Result]) -> int:
    """Compute the steady train and analyse it; return the exit status.

    Raises:
        CaseError: for anything in the request that is not allowed, before computing.
    """
    case = read_case(request.case) if request.case else None
    start = _start(request.start) if request.start else None
    train = _train(case, start, leaves)
    analysis.check(train)
    if request.output:
        check_output(request.output)
    if request.plot:
        check_folder(request.plot)
    errors = Console(stderr=True)
    # Only the result itself may go to standard output.
    with redirect_stdout(sys.stderr), Reporter(errors, quiet=request.quiet) as reporter:
        try:
            base = steady(train, start=start, progress=reporter.iteration)
        except NotConverged as failure:
            return _not_converged(failure, errors, request.output)
        result = analysis.compute(base, reporter)
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
