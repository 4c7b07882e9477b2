"""Progress on standard error: bars for what has parts, a running line for the base flow."""

import math
import time
from collections.abc import Callable
from contextlib import ExitStack
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from numba.core import event
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from celltrain.cli.keeping import ERRORS, say

if TYPE_CHECKING:
    from celltrain.contract.progress import SimulationStatus
    from celltrain.steady import Iteration

# Where there is no terminal: seconds after which a line says how far it is.
LINE_SECONDS = 60.0


class _Announcement(event.Listener):
    """Says once that loops are being compiled: the first run takes some seconds longer."""

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say
        self._said = False

    def on_start(self, event: Any) -> None:
        """Called when a compilation begins."""
        del event
        if not self._said:
            self._said = True
            self._say("compiling loops for this machine; they are kept for later runs")

    def on_end(self, event: Any) -> None:
        """Called when it ends."""


class Reporter:
    """Shows how a computation goes on; gives the callbacks that the computations take.

    On a terminal it is a live display; otherwise a line for each iteration and, of what has an
    end, for each tenth and each minute.
    """

    def __init__(self, *, quiet: bool = False) -> None:
        self._quiet = quiet
        self._live = ERRORS.is_terminal
        self._iterations = 0
        self._tenths = 0
        self._line_at = time.monotonic()
        self._title = ""
        self._open = ExitStack()
        self._progress = Progress(
            SpinnerColumn(),
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.fields[note]}"),
            TimeElapsedColumn(),
            console=ERRORS,
            transient=True,
            disable=quiet or not self._live,
        )
        self._task = self._progress.add_task("starting", total=None, note="")

    def __enter__(self) -> Self:
        self._progress.start()
        self._open.enter_context(event.install_listener("numba:compile", _Announcement(self.log)))
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._open.close()
        self._progress.stop()

    def log(self, message: str) -> None:
        """One line, unless quiet."""
        if not self._quiet:
            say(message)

    def iteration(self, iteration: "Iteration") -> None:
        """Take an iteration of the steady train."""
        self._iterations += 1
        note = f"residual {iteration.residual:.2e}  cell velocity {iteration.cell_velocity:.5f}"
        title = f"steady train: {iteration.method} {self._iterations}"
        if self._live:
            self._progress.update(self._task, description=title, note=note)
        else:
            self.log(f"{title}  {note}")

    def share(self, done: int, total: int) -> None:
        """Take how much of the linearisation is done."""
        self.part("linear dynamics", done, total)

    def part(self, title: str, done: int, total: int) -> None:
        """Take how much of something is done."""
        self._reach(title, done, total, f"{done} of {total}")

    def step(self, status: "SimulationStatus") -> None:
        """Take how far a simulation is: time, speed (r0/U per hour), time left and eps."""
        note = f"t = {status.time:.4g} of {status.until:g} r0/U  {progress_note(status)}"
        self._reach("simulation", status.time, status.until, note)

    def _reach(self, title: str, done: float, total: float, note: str) -> None:
        if title != self._title:
            self._title, self._tenths = title, 0
        if self._live:
            self._progress.update(
                self._task, description=title, completed=done, total=total, note=note
            )
        elif total:
            tenths, now = int(10 * done / total), time.monotonic()
            if tenths > self._tenths or now - self._line_at >= LINE_SECONDS:
                self._tenths, self._line_at = tenths, now
                self.log(f"{title}: {note}")


def progress_note(status: "SimulationStatus") -> str:
    """Speed, time left and eps of a simulation in words."""
    speed = 3600.0 * (status.time - status.begin) / status.seconds
    left = 3600.0 * (status.until - status.time) / speed if speed > 0.0 else math.inf
    duration = f"{left / 3600.0:.1f} h" if left > 3600.0 else f"{left / 60.0:.1f} min"
    return f"{speed:.3g} r0/U per hour, {duration} left, eps {status.eps:.3g} r0"
