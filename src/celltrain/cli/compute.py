"""The commands that compute: from a checked case to a report, a file, pictures, or JSON."""

import json
import math
import sys
from collections.abc import Mapping, Sequence
from contextlib import redirect_stdout
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from celltrain.cli.outputs import check_folder, check_output, last_state_path
from celltrain.cli.progress import Reporter
from celltrain.parameters import CaseError, Train, merge_case, read_case
from celltrain.results import print_report, summary
from celltrain.stability import (
    ACCURACY,
    Stability,
    check_accuracy,
    check_count,
    check_linearisable,
    stability,
    with_error_bars,
)
from celltrain.steady import Base, Iteration, NotConverged, steady

#: Exit status of a computation that did not converge.
NOT_CONVERGED = 3


@dataclass(frozen=True)
class Request:
    """What a command was asked for, apart from the case itself."""

    case: Path | None = None
    start: Path | None = None
    output: Path | None = None
    plot: Path | None = None
    json: bool = False
    quiet: bool = False


def run(
    request: Request,
    leaves: Mapping[str, Any],
    *,
    stable: bool,
    azimuthal_numbers: Sequence[int] | None = None,
    error_bars: int | None = None,
    accuracy: float = ACCURACY,
) -> int:
    """Compute the steady train, and its stability if ``stable``; return the exit status.

    Raises:
        CaseError: for anything in the request that is not allowed, before computing.
    """
    case = read_case(request.case) if request.case else None
    start = read_start(request.start) if request.start else None
    train = read_train(case, start, leaves)
    if stable:
        check_linearisable(train, azimuthal_numbers)
        check_accuracy(accuracy)
        if error_bars is not None:
            check_count(error_bars)
    if request.output:
        check_output(request.output)
    if request.plot:
        check_folder(request.plot)

    errors = Console(stderr=True)
    # Only the result itself may go to standard output.
    with redirect_stdout(sys.stderr), Reporter(errors, quiet=request.quiet) as reporter:
        degree = train.resolution.degree
        reporter.log(
            f"train of {train.cells} cells, packing {train.packing:g}, in a tube of diameter"
            f" {train.tube.diameter:g} r0" + ("" if degree is None else f", degree {degree}")
        )
        result: Base | Stability
        try:
            if stable:
                result = stability(
                    train,
                    start=start,
                    accuracy=accuracy,
                    azimuthal_numbers=azimuthal_numbers,
                    estimate_error=error_bars is None,
                    progress=reporter.share,
                    iteration=reporter.iteration,
                    tell=reporter.log,
                )
            else:
                result = steady(train, start=start, progress=reporter.iteration)
        except NotConverged as failure:
            return describe_failure(failure, errors, request.output)
        if error_bars is not None and isinstance(result, Stability):
            reporter.log("error bars: higher degrees, then finer rules")
            result = with_error_bars(result, count=error_bars)
        _keep(result, request, reporter)
    _show(result, as_json=request.json)
    return 0


def read_train(
    case: Mapping[str, Any] | None, start: Base | None, leaves: Mapping[str, Any]
) -> Train:
    """The case of a request: its file's, or its start's, with the options' leaves.

    Raises:
        CaseError: for what is not allowed.
    """
    if case is None and start is not None:
        if leaves.get("units") == "SI":
            return merge_case(start.train.leaves("SI"), leaves)
        changes = {name: value for name, value in leaves.items() if name != "units"}
        return start.train.changed(**changes)
    return merge_case(case or {}, leaves)


def read_start(path: Path) -> Base:
    """The steady train in a result file.

    Raises:
        CaseError: if there is none.
    """
    if not path.is_file():
        raise CaseError(f"start = {str(path)!r} cannot be read: there is no such file")
    # Files take half a second to load.
    from celltrain.results import load

    try:
        result = load(path)
    except (OSError, ValueError) as error:
        raise CaseError(f"start = {str(path)!r} is no result of celltrain: {error}") from None
    return result if isinstance(result, Base) else result.base


def _keep(result: Base | Stability, request: Request, reporter: Reporter) -> None:
    if request.output:
        from celltrain.results import save

        save(result, request.output)
        reporter.log(f"saved {request.output}")
    if request.plot:
        # Drawing takes half a second to load.
        from celltrain.pictures import plot_all

        for path in plot_all(result, request.plot):
            reporter.log(f"drew {path}")


def _show(result: Base | Stability, *, as_json: bool) -> None:
    if not as_json:
        print_report(result, Console())
        return
    content = summary(result)
    if isinstance(result, Base):
        content["history"] = [_plain(iteration) for iteration in result.history]
    print(json.dumps(content, indent=2, allow_nan=False))


def _plain(iteration: Iteration) -> dict[str, Any]:
    """An iteration as JSON can hold it: Newton's infinite step becomes None."""
    values = asdict(iteration)
    return values | {"step": values["step"] if math.isfinite(values["step"]) else None}


def describe_failure(failure: NotConverged, errors: Console, output: Path | None) -> int:
    """Say why there is no steady train, keep the last state; return the exit status."""
    errors.print(f"not converged: {failure}", markup=False, highlight=False)
    table = Table("iteration", "method", "residual, U", "step, r0/U", "cell velocity, U")
    for number, iteration in enumerate(failure.history, 1):
        table.add_row(
            str(number),
            iteration.method,
            f"{iteration.residual:.3e}",
            f"{iteration.step:.3g}",
            f"{iteration.cell_velocity:.6f}",
        )
    errors.print(table)
    from celltrain.results import save

    path = last_state_path(output)
    try:
        save(failure.last, path)
    except OSError as error:
        errors.print(f"the last state could not be saved as {path}: {error}", markup=False)
    else:
        errors.print(f"the last state is in {path}; go on from it with --start", markup=False)
    return NOT_CONVERGED
