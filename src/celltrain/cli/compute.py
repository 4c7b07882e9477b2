"""The one way of a command that computes: from a checked case to report, file and pictures.

What is written while it is computed (`WrittenMeanwhile`) has its file to itself all the time, can
be gone on with, and is not replaced unasked.
"""

import json as json_module
import os
import sys
from collections.abc import Callable, Mapping
from contextlib import nullcontext, redirect_stdout
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from celltrain.cli.keeping import ERRORS, Keeper, Report, reason, say
from celltrain.cli.outputs import check_folder, check_output, last_state_path
from celltrain.cli.progress import Reporter
from celltrain.contract import Analysis, Progress, WrittenMeanwhile, load, presentation
from celltrain.contract.status import ExitStatus
from celltrain.contract.tables import titled
from celltrain.parameters import CaseError, Train, check_volume, merge_case, read_case
from celltrain.parameters.train import Units
from celltrain.quantities import Record
from celltrain.results.lock import only_writer
from celltrain.stability import Stability
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
        KeyboardInterrupt: with what is kept as the message, of what was interrupted.
    """
    meanwhile = isinstance(analysis, WrittenMeanwhile)
    if meanwhile and request.output is None:
        raise CaseError("output is missing: name a file (-o FILE.nc)")
    if request.output:
        check_output(request.output)
    # Nobody else may come between looking at the file and writing it.
    own = only_writer(request.output) if meanwhile and request.output else nullcontext()
    # Only the result itself may go to standard output.
    with redirect_stdout(sys.stderr), own:
        compute = _checked(request, leaves, analysis)
        if request.plot:
            check_folder(request.plot)
        with Reporter(quiet=request.quiet) as reporter:
            try:
                result = compute(reporter)
            except NotConverged as failure:
                return describe_failure(failure, request.output)
    keeper = Keeper(quiet=request.quiet)
    print_result(result, keeper, as_json=request.json)
    status, remark = analysis.status(result), analysis.remark(result, request.output)
    if meanwhile and status == ExitStatus.INTERRUPTED:
        raise KeyboardInterrupt(remark)
    if remark:
        say(remark)
    keeper.result(result, None if meanwhile else request.output, request.plot)
    return status or keeper.status


def _checked(
    request: Request, leaves: Mapping[str, object], analysis: Analysis[Record]
) -> Callable[[Progress], Record]:
    """What computes, once everything in the request is found to be allowed."""
    output = request.output
    if isinstance(analysis, WrittenMeanwhile) and output is not None:
        if analysis.resume:
            _check_resumed(request, leaves)
            return partial(analysis.go_on, output)
        if output.exists() and not analysis.overwrite:
            raise CaseError(
                f"output = {str(output)!r} is not allowed: it exists; allowed: another file, or"
                " --resume, or --overwrite"
            )
    train, known, units = read_request(request, {**leaves, **analysis.leaves()})
    start = None if known is None else presentation(known.kind).steady_train(known)
    if units == "SI":
        analysis = analysis.dimensionless(train.scales)
    of_result = request.case is None or request.case.suffix.lower() == ".nc"
    if isinstance(analysis, WrittenMeanwhile) and of_result and "degree" not in leaves:
        # The degree in a result's file is that of its own computation.
        train = train.changed(degree=None)
    analysis.check(train)

    def compute(progress: Progress) -> Record:
        degree = train.resolution.degree
        progress.log(
            f"train of {train.cells} cells, packing {train.packing:g}, in a tube of diameter"
            f" {train.tube.diameter:g} r0" + ("" if degree is None else f", degree {degree}")
        )
        if isinstance(analysis, WrittenMeanwhile):
            begin = known if isinstance(known, Stability) else start
            return analysis.compute_into(train, begin, progress, output)
        return analysis.compute(train, start, progress)

    return compute


def _check_resumed(request: Request, leaves: Mapping[str, object]) -> None:
    if request.case is not None or request.start is not None or leaves:
        raise CaseError(
            "a case is not allowed with --resume: the computation goes on with that of its file"
        )
    if not request.output or not request.output.is_file():
        raise CaseError(
            f"output = {str(request.output)!r} cannot be resumed: there is no such file"
        )


def read_request(
    request: Request, leaves: Mapping[str, object]
) -> tuple[Train, Record | None, Units]:
    """The case that a request means, the result to start from if there is one, and the units.

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
    known = read_result(start, name) if start else None
    base = None if known is None else presentation(known.kind).steady_train(known)
    content = read_case(case) if case else None
    train = read_train(content, base, leaves)
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
            check_volume(train.cell)
        return train
    return merge_case(case or {}, leaves)


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
        keeper.show(lambda: shown.report(result, Report()))


def describe_failure(failure: NotConverged, output: Path | None) -> int:
    """Say why there is no steady train, keep the last state; return the exit status."""
    say(f"celltrain: not converged: {failure}")
    table = titled("", "iteration", "method", "residual, U", "step, r0/U", "cell velocity, U")
    for number, iteration in enumerate(failure.history, 1):
        table.add_row(
            str(number),
            iteration.method,
            f"{iteration.residual:.3e}",
            f"{iteration.step:.3g}",
            f"{iteration.cell_velocity:.6f}",
        )
    ERRORS.print(table)
    from celltrain.results import save

    path = last_state_path(output)
    try:
        save(failure.last, path)
    except OSError as error:
        lost = f"{str(path)!r} could not be written, with the last state"
        say(f"celltrain: {lost}: {reason(error)}")
    else:
        train = failure.last.train
        say(
            f"the last state is in {path} (diameter {train.tube.diameter:.6g}, packing"
            f" {train.packing:.6g}); repeat the command with --start {path} to go on from there"
        )
    return ExitStatus.NOT_CONVERGED
