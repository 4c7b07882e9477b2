"""The one way of a command that computes: from a checked case to report, file and pictures."""

import json as json_module
import os
import sys
from collections.abc import Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from celltrain.cli.failure import reason
from celltrain.cli.keeping import Keeper
from celltrain.cli.outputs import check_folder, check_output, last_state_path
from celltrain.cli.progress import Reporter
from celltrain.contract import Analysis, load, presentation
from celltrain.contract.status import ExitStatus
from celltrain.contract.tables import titled
from celltrain.parameters import CaseError, Train, check_volume, merge_case, read_case
from celltrain.parameters.train import Units
from celltrain.quantities import Record
from celltrain.steady import Base, NotConverged


@dataclass(frozen=True)
class Request:
    """What a command was asked for, apart from the case itself."""

    case: Path | None = None
    start: Path | None = None
    output: Path | None = None
    plot: Path | None = None
    json: bool = False
    quiet: bool = False


def run(request: Request, leaves: Mapping[str, object], analysis: Analysis[Record]) -> int:
    """Compute what is asked for, show it and keep it; return the exit status.

    Raises:
        CaseError: for anything in the request that is not allowed, before computing.
    """
    train, start, units = read_request(request, {**leaves, **analysis.leaves()})
    if units == "SI":
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
    keeper = Keeper(errors, quiet=request.quiet)
    print_result(result, keeper, as_json=request.json)
    keeper.result(result, request.output, request.plot)
    return analysis.status(result) or keeper.status


def read_request(
    request: Request, leaves: Mapping[str, object]
) -> tuple[Train, Base | None, Units]:
    """The case that a request means, the steady train to start from if there is one, and the units.

    These are those of the options, or else of the case file.

    Raises:
        CaseError: for what is not allowed.
    """
    case, start = request.case, request.start
    name = "start"
    if case is not None and case.suffix.lower() == ".nc":
        if start is not None:
            raise CaseError(
                f"case = {str(case)!r} is not allowed with start = {str(start)!r}: both hold a"
                " steady train; allowed: one of them, or a case file (.toml)"
            )
        case, start, name = None, case, "case"
    known = read_start(start, name) if start else None
    content = read_case(case) if case else None
    train = read_train(content, known, leaves)
    in_si = {**(content or {}), **leaves}.get("units") == "SI"
    return train, known, "SI" if in_si else "dimensionless"


def read_train(
    case: Mapping[str, object] | None, start: Base | None, leaves: Mapping[str, object]
) -> Train:
    """The case of a request: its file's, or its start's, with the options' leaves.

    Raises:
        CaseError: for what is not allowed.
    """
    if case is None and start is not None:
        if leaves.get("units") == "SI":
            return merge_case(start.train.leaves("SI"), leaves)
        words = ("units", "unusual")
        train = start.train.changed(
            **{name: value for name, value in leaves.items() if name not in words}
        )
        if "profile" in leaves and not leaves.get("unusual"):
            check_volume(train)
        return train
    return merge_case(case or {}, leaves)


def read_start(path: Path, name: str) -> Base:
    """The steady train in a result file; `name` is that of the option in messages.

    Raises:
        CaseError: if there is none.
    """
    result = read_result(path, name)
    return presentation(result.kind).steady_train(result)


def read_result(path: Path, name: str) -> Record:
    """What a file holds; `name` is that of the option or argument in messages.

    Raises:
        CaseError: if there is no such file, or it holds no result.
    """
    if not os.path.isfile(path):
        raise CaseError(f"{name} = {str(path)!r} cannot be read: there is no such file")
    try:
        return load(path)
    except (OSError, ValueError) as error:
        raise CaseError(f"{name} = {str(path)!r} is not a result of celltrain: {error}") from None


def print_result(result: Record, keeper: Keeper, *, as_json: bool) -> None:
    """Print the report of a result, or its JSON."""
    shown = presentation(result.kind)
    if as_json:
        text = json_module.dumps(shown.summary(result), indent=2, allow_nan=False)
        keeper.show(lambda: print(text))
    else:
        keeper.show(lambda: shown.report(result, Console()))


def describe_failure(failure: NotConverged, errors: Console, output: Path | None) -> int:
    """Say why there is no steady train, keep the last state; return the exit status."""
    words = f"celltrain: not converged: {failure}"
    errors.print(words, markup=False, highlight=False, soft_wrap=True)
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
        words = (
            f"celltrain: {str(path)!r} could not be written, with the last state: {reason(error)}"
        )
        errors.print(words, markup=False, highlight=False, soft_wrap=True)
    else:
        train = failure.last.train
        words = (
            f"the last state is in {path} (diameter {train.tube.diameter:.6g}, packing"
            f" {train.packing:.6g}); repeat the command with --start {path} to go on from there"
        )
        errors.print(words, markup=False, highlight=False, soft_wrap=True)
    return ExitStatus.NOT_CONVERGED
