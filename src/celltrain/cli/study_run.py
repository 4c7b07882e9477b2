"""The run of a study from the command line, with live progress: what sweeps and figures share."""

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.progress import Progress as Bar

from celltrain.cli.arguments import Quiet
from celltrain.cli.failure import CommandFailed, reason
from celltrain.cli.options import reader
from celltrain.contract.status import ExitStatus
from celltrain.interruption import kept_by
from celltrain.parameters import CaseError
from celltrain.study import (
    CaseRecord,
    NotKept,
    StabilityOfCase,
    Study,
    StudyProgress,
    Workers,
    WorkersLost,
    local_workers,
    run_study,
    scheduled_workers,
)

# Cases take minutes, so the time left follows from the last hour.
SPEED_PERIOD = 3600.0

Count = Annotated[
    int | None,
    Parameter(
        converter=reader(int, "allowed: a whole number >= 1"),
        help="Processes of this machine; as many as it has processors unless given.",
    ),
]
Scheduler = Annotated[
    str | None,
    Parameter(help="Address of a dask scheduler that runs already, such as tcp://node1:8786."),
]
Retry = Annotated[bool, Parameter(help="Compute failed cases again.", negative=())]


@dataclass(frozen=True)
class StudyRun:
    """How a study is run: where to, by what, and whether failed cases are computed again."""

    folder: Path
    workers: int | None = None
    scheduler: str | None = None
    retry: bool = False
    quiet: Quiet = False


def compute(study: Study, run: StudyRun, errors: Console) -> dict[tuple[int, ...], CaseRecord]:
    """Run or resume a study; returns the records by the cases' indices.

    `run.folder` is there.

    Raises:
        CaseError: for workers that are not allowed.
        CommandFailed, KeyboardInterrupt: with what is kept as the message.
    """
    if run.workers is not None and run.scheduler is not None:
        raise CaseError("workers and scheduler are not allowed together: give one of them")
    computation = StabilityOfCase(study.computed)
    last: list[StudyProgress] = []

    def kept() -> str:
        finished = last[0].finished if last else 0
        return (
            f"{finished} of {len(study.cases)} cases are finished and kept in {run.folder};"
            " the same command goes on with the others"
        )

    try:
        with (
            kept_by(kept),
            _workers(run) as workers,
            _shown(study, errors, quiet=run.quiet) as show,
        ):

            def tell(progress: StudyProgress) -> None:
                last[:] = [progress]
                show(progress)

            return run_study(
                study,
                run.folder.absolute(),
                computation,
                workers.executor,
                workers.slots,
                retry=run.retry,
                progress=tell,
            )
    except (KeyboardInterrupt, WorkersLost, NotKept, OSError) as stopped:
        if isinstance(stopped, KeyboardInterrupt):
            raise KeyboardInterrupt(kept()) from None
        if isinstance(stopped, WorkersLost):
            raise CommandFailed(f"{stopped}; {kept()}", ExitStatus.NOT_KEPT) from None
        raise CommandFailed(
            f"{str(run.folder)!r} could not be written: {reason(stopped)}; {kept()}",
            ExitStatus.NOT_KEPT,
        ) from None


def _workers(run: StudyRun) -> AbstractContextManager[Workers]:
    return scheduled_workers(run.scheduler) if run.scheduler else local_workers(run.workers)


@contextmanager
def _shown(study: Study, errors: Console, *, quiet: bool) -> "Iterator[_Show]":
    live = errors.is_terminal
    bar = Bar(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[note]}"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        console=errors,
        transient=True,
        disable=quiet or not live,
        speed_estimate_period=SPEED_PERIOD,
    )
    with bar:
        yield _Show(study, bar, errors, lines=not quiet)


class _Show:
    """Shows where a study stands: a bar on a terminal, and a line for each case that ends."""

    def __init__(self, study: Study, bar: Bar, errors: Console, *, lines: bool) -> None:
        self._bar = bar
        self._errors = errors
        self._lines = lines
        self._task = bar.add_task(study.title, total=len(study.cases), note="")

    def __call__(self, progress: StudyProgress) -> None:
        done = progress.finished + progress.failed
        note = f"{progress.failed} failed" if progress.failed else ""
        self._bar.update(self._task, completed=done, note=note)
        if not self._lines:
            return
        if progress.last is None:
            self._print(f"{done} of {progress.total} cases were there already")
            return
        case, record = progress.last
        alpha = record.values.get("spectral_abscissa")
        result = f"failed: {record.reason}" if record.status == "failed" else f"alpha {alpha:.2e}"
        self._print(f"{done}/{progress.total}  {case}: {result}")

    def _print(self, line: str) -> None:
        self._errors.print(line, highlight=False, markup=False, soft_wrap=True)
