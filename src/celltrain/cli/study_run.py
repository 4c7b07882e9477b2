"""The run of a study from the command line, with live progress: what sweeps and figures share."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, TypeVar

from cyclopts import Parameter
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.progress import Progress as Bar

from celltrain.cli.arguments import Quiet
from celltrain.cli.keeping import ERRORS, reason, say
from celltrain.cli.options import reader
from celltrain.contract.status import ComputationFailed, ExitStatus
from celltrain.interruption import kept_by
from celltrain.parameters import CaseError
from celltrain.study import (
    CaseRecord,
    NotKept,
    StabilityOfCase,
    Study,
    StudyProgress,
    WorkersLost,
    local_workers,
    run_study,
    scheduled_workers,
)
from celltrain.study.sampling.definition import SampledStudy
from celltrain.study.sampling.engine import NoCentralTrain, Sampled, run_sample

Found = TypeVar("Found")

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


def compute(study: Study, run: StudyRun) -> dict[tuple[int, ...], CaseRecord]:
    """Run or resume a study; returns the records by the cases' indices.

    `run.folder` is there.

    Raises:
        CaseError: for workers that are not allowed.
        ComputationFailed, KeyboardInterrupt: with what is kept as the message.
    """
    folder, computation = run.folder.absolute(), StabilityOfCase(study.computed)
    show = _Show(study.title, len(study.cases), run)
    return _kept_going(partial(run_study, study, folder, computation), run, show)


def compute_sample(study: SampledStudy, run: StudyRun) -> Sampled:
    """The same for a study of distributions.

    Raises:
        CaseError, ComputationFailed, KeyboardInterrupt: as `compute`.
    """
    show = _Show(study.title, study.total, run, many=True)
    try:
        return _kept_going(partial(run_sample, study, run.folder.absolute()), run, show)
    except NoCentralTrain as error:
        raise ComputationFailed(str(error)) from None


def _kept_going(on_workers: Callable[..., Found], run: StudyRun, show: "_Show") -> Found:
    """Run what workers do, with progress; whatever stops it says what is kept."""
    if run.workers is not None and run.scheduler is not None:
        raise CaseError("workers and scheduler are not allowed together: give one of them")
    found = scheduled_workers(run.scheduler) if run.scheduler else local_workers(run.workers)

    def kept() -> str:
        return (
            f"{show.finished} of {show.total} cases are finished and kept in {run.folder};"
            " the same command goes on with the others"
        )

    try:
        with kept_by(kept), found as workers, show:
            return on_workers(workers.executor, workers.slots, retry=run.retry, progress=show)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(kept()) from None
    except (WorkersLost, NotKept, OSError) as stopped:
        words = f"{str(run.folder)!r} could not be written: {reason(stopped)}"
        words = str(stopped) if isinstance(stopped, WorkersLost) else words
        raise ComputationFailed(f"{words}; {kept()}", ExitStatus.NOT_KEPT) from None


class _Show:
    """Shows where a study stands: a bar on a terminal, and a line for each case that ends.

    Of many cases only those that fail have a line of their own, and each tenth of all.
    """

    def __init__(self, title: str, total: int, run: StudyRun, *, many: bool = False) -> None:
        self.total, self.finished = total, 0
        self._quiet, self._many = run.quiet, many
        self._tenth = 0
        self._bar = Bar(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[note]}"),
            TimeElapsedColumn(),
            TextColumn("left"),
            TimeRemainingColumn(),
            console=ERRORS,
            transient=True,
            disable=run.quiet or not ERRORS.is_terminal,
            speed_estimate_period=SPEED_PERIOD,
        )
        self._task = self._bar.add_task(title, total=total, note="")

    def __enter__(self) -> None:
        self._bar.start()

    def __exit__(self, *_: object) -> None:
        self._bar.stop()

    def __call__(self, progress: StudyProgress) -> None:
        self.finished = progress.finished
        done = progress.finished + progress.failed
        note = f"{progress.failed} failed" if progress.failed else ""
        self._bar.update(self._task, completed=done, note=note)
        if self._quiet:
            return
        if not progress.ended:
            say(f"{done} of {progress.total} cases were there already")
        for case, record in progress.ended:
            if record.status == "failed":
                say(f"{done}/{progress.total}  {case}: failed: {record.reason}")
            elif not self._many:
                alpha = record.values.get("spectral_abscissa")
                say(f"{done}/{progress.total}  {case}: alpha {alpha:.2e}")
        tenth = 10 * done // progress.total
        if self._many and progress.ended and tenth > self._tenth:
            say(f"{done}/{progress.total}")
        self._tenth = tenth
