"""The one way of a command that computes: from a checked case to report, file and pictures."""

import json as json_module
import sys
from collections.abc import Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from celltrain.cli.outputs import check_folder, check_output, last_state_path
from celltrain.cli.progress import Reporter
from celltrain.contract import Analysis, load, presentation
from celltrain.contract.files import draw_each
from celltrain.contract.tables import titled
from celltrain.parameters import CaseError, Train, merge_case, read_case
from celltrain.quantities import Record
from celltrain.results import replace_file
from celltrain.steady import Base, NotConverged

#: Exit status of a computation that did not converge.
NOT_CONVERGED = 3
#: Exit status when something that was asked for could not be written; the result was printed.
NOT_KEPT = 4


@dataclass(frozen=True)
class Request:
    """What a command was asked for, apart from the case itself."""

    case: Path | None = None
    start: Path | None = None
    output: Path | None = None
    plot: Path | None = None
    json: bool = False
    quiet: bool = False


def run(request: Request, leaves: Mapping[str, Any], analysis: Analysis[Any]) -> int:
    """Compute what is asked for, show it and keep it; return the exit status.

    Raises:
        CaseError: for anything in the request that is not allowed, before computing.
    """
    train, start = read_request(request, {**leaves, **analysis.leaves()})
    if leaves.get("units") == "SI":
        analysis = analysis.dimensionless(train.scales)
    analysis.check(train)
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
        try:
            result = analysis.compute(train, start, reporter)
        except NotConverged as failure:
            return describe_failure(failure, errors, request.output)
    print_result(result, as_json=request.json)
    kept = keep(result, request, errors)
    return analysis.status(result) or (0 if kept else NOT_KEPT)


def read_request(request: Request, leaves: Mapping[str, Any]) -> tuple[Train, Base | None]:
    """The case that a request means, and the steady train to start from if there is one.

    Raises:
        CaseError: for what is not allowed.
    """
    case, start = request.case, request.start
    if case is not None and case.suffix == ".nc":
        if start is not None:
            raise CaseError(
                f"case = {str(case)!r} is not allowed with start = {str(start)!r}: both hold a"
                " steady train; allowed: one of them, or a case file (.toml)"
            )
        case, start = None, case
    known = read_start(start) if start else None
    return read_train(read_case(case) if case else None, known, leaves), known


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
    result = read_result(path, "start")
    return presentation(result.kind).steady_train(result)


def read_result(path: Path, name: str) -> Record:
    """What a file holds; `name` is that of the option or argument in messages.

    Raises:
        CaseError: if there is no such file, or it holds no result.
    """
    if not path.is_file():
        raise CaseError(f"{name} = {str(path)!r} cannot be read: there is no such file")
    try:
        return load(path)
    except (OSError, ValueError) as error:
        raise CaseError(f"{name} = {str(path)!r} is no result of celltrain: {error}") from None


def print_result(result: Record, *, as_json: bool) -> None:
    """Print the report of a result, or its JSON."""
    shown = presentation(result.kind)
    if as_json:
        print(json_module.dumps(shown.summary(result), indent=2, allow_nan=False))
    else:
        shown.report(result, Console())


def keep(result: Record, request: Request, errors: Console) -> bool:
    """Save and draw what was asked for; say what could not be, and return whether all was kept."""
    from celltrain.results import save  # files take half a second to load

    def say(message: str) -> None:
        errors.print(message, markup=False, highlight=False, soft_wrap=True)

    def tell(message: str) -> None:
        if not request.quiet:
            say(message)

    kept = True
    if request.output:
        for path, each in presentation(result.kind).files(result, request.output).items():
            try:
                save(each, path)
            except OSError as error:
                say(f"celltrain: {str(path)!r} could not be written: {_reason(error)}")
                kept = False
            else:
                tell(f"saved {path}")
    if request.plot:
        for path, failure in draw_each(result, request.plot):
            if failure is None:
                tell(f"drew {path}")
            else:
                say(f"celltrain: {str(path)!r} could not be drawn: {_reason(failure)}")
                kept = False
    return kept


def keep_text(text: str, path: Path, errors: Console, *, quiet: bool) -> bool:
    """Write a text file at once; say if it could not be written, and return whether it was."""
    try:
        replace_file(path, lambda part: part.write_text(text, encoding="utf-8"))
    except OSError as error:
        message = f"celltrain: {str(path)!r} could not be written: {_reason(error)}"
        errors.print(message, markup=False, highlight=False, soft_wrap=True)
        return False
    if not quiet:
        errors.print(f"wrote {path}", markup=False, highlight=False, soft_wrap=True)
    return True


def _reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error) or type(error).__name__


def describe_failure(failure: NotConverged, errors: Console, output: Path | None) -> int:
    """Say why there is no steady train, keep the last state; return the exit status."""
    errors.print(f"not converged: {failure}", markup=False, highlight=False)
    table = titled("", "iteration", "method", "residual, U", "step, r0/U", "cell velocity, U")
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
