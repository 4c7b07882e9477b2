"""The one way of a command that computes many cases into a folder, with live progress."""

import json as json_module
import sys
from collections.abc import Callable
from contextlib import redirect_stdout
from dataclasses import dataclass
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

from celltrain.cli.keeping import ERRORS, Keeper, reason, say
from celltrain.cli.options import reader
from celltrain.cli.outputs import check_folder
from celltrain.contract import InFolder
from celltrain.contract.status import ComputationFailed, ExitStatus
from celltrain.interruption import kept_by
from celltrain.parameters import CaseError
from celltrain.results import only_writer
from celltrain.study import (
    NotKept,
    StudyProgress,
    WorkersLost,
    local_workers,
    scheduled_workers,
)

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


def folder_option(computation: type[InFolder]) -> object:
    """The option that names the folder, whose help says which is the usual one."""
    usual, *_ = (computation.folder.__doc__ or "").splitlines()
    return Annotated[
        Path | None,
        Parameter(
            name=("--output", "-o"),
            help="Folder for the results, made if it is not there. What it holds already is not"
            f" computed again. Unless given: {usual[:1].lower()}{usual[1:]}",
        ),
    ]


@dataclass(frozen=True)
class FolderRequest:
    """What a command was asked for, apart from its settings: where to, by what, and how it tells.

    With `retry` failed cases are computed again.
    """

    output: Path | None = None
    workers: int | None = None
    scheduler: str | None = None
    retry: bool = False
    json: bool = False
    quiet: bool = False


def run_in_folder(request: FolderRequest, computation: InFolder) -> int:
    """Compute or go on, show what there is, write and draw it; return the exit status.

    Raises:
        CaseError: for anything in the request that is not allowed, before computing.
        ComputationFailed, KeyboardInterrupt: with what is kept as the message.
    """
    if request.workers is not None and request.scheduler is not None:
        raise CaseError("workers and scheduler are not allowed together: give one of them")
    computation.check()
    folder = request.output or computation.folder
    check_folder(folder, "output")
    with only_writer(folder):
        # Only the result itself may go to standard output.
        with redirect_stdout(sys.stderr):
            kept = computation.compute(folder, _Crew(folder, request))
        shown = json_module.dumps(kept.summary, indent=2) + "\n" if request.json else kept.report
        keeper = Keeper(quiet=request.quiet)
        keeper.show(lambda: sys.stdout.write(shown))
        for name, text in kept.texts.items():
            keeper.text(folder / name, text)
        for name, each in kept.results.items():
            keeper.saved(folder / name, each)
        keeper.pictures(kept.pictures, folder)
        if kept.remark and not request.quiet:
            say(kept.remark)
        return kept.status or keeper.status


class _Crew:
    """Workers of this machine or of a cluster; whatever stops them says what is kept."""

    def __init__(self, folder: Path, request: FolderRequest) -> None:
        self._folder, self._request = folder, request

    @property
    def retry(self) -> bool:
        return self._request.retry

    def __call__(
        self, run: Callable[..., Found], title: str, total: int, *, many: bool = False
    ) -> Found:
        show = _Show(title, total, quiet=self._request.quiet, many=many)
        scheduler = self._request.scheduler
        found = scheduled_workers(scheduler) if scheduler else local_workers(self._request.workers)

        def kept() -> str:
            return (
                f"{show.finished} of {total} cases are finished and kept in {self._folder};"
                " the same command goes on with the others"
            )

        try:
            with kept_by(kept), found as workers, show:
                return run(workers.executor, workers.slots, retry=self.retry, progress=show)
        except KeyboardInterrupt:
            raise KeyboardInterrupt(kept()) from None
        except (WorkersLost, NotKept, OSError) as stopped:
            words = f"{str(self._folder)!r} could not be written: {reason(stopped)}"
            words = str(stopped) if isinstance(stopped, WorkersLost) else words
            raise ComputationFailed(f"{words}; {kept()}", ExitStatus.NOT_KEPT) from None


class _Show:
    """Shows where a study stands: a bar on a terminal, and a line for each case that ends.

    Of many cases only those that fail have a line of their own, and each tenth of all.
    """

    def __init__(self, title: str, total: int, *, quiet: bool, many: bool) -> None:
        self.finished = 0
        self._quiet, self._many = quiet, many
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
            disable=quiet or not ERRORS.is_terminal,
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
