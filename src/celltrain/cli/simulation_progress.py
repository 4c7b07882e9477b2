"""A simulation in the terminal: its progress."""

import math
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

from celltrain.evolution.march import Status


class SimulationReporter:
    """Shows simulated time, speed (r0/U per hour), time left and eps.

    On a terminal as a bar, otherwise as a line for each tenth.
    """

    def __init__(self, console: Console, *, quiet: bool) -> None:
        self._console, self._quiet = console, quiet
        self._live = console.is_terminal
        self._tenths = 0
        self._progress = Progress(
            TextColumn("t = {task.fields[time]} of {task.fields[until]} r0/U"),
            BarColumn(),
            TextColumn("{task.fields[note]}"),
            console=console,
            transient=True,
            disable=quiet or not self._live,
        )
        self._task = self._progress.add_task("", total=1.0, time="0", until="?", note="starting")

    def __enter__(self) -> "SimulationReporter":
        self._progress.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._progress.stop()

    def step(self, status: Status) -> None:
        """Take how far the simulation is."""
        note = progress_note(status)
        if self._live:
            self._progress.update(
                self._task,
                completed=status.time / status.until,
                time=f"{status.time:.4g}",
                until=f"{status.until:g}",
                note=note,
            )
            return
        tenths = int(10.0 * status.time / status.until)
        if tenths > self._tenths and not self._quiet:
            self._tenths = tenths
            self._console.print(
                f"t = {status.time:.4g} of {status.until:g} r0/U  {note}",
                highlight=False,
                markup=False,
                soft_wrap=True,
            )


def progress_note(status: Status) -> str:
    """Speed, time left and eps in words."""
    speed = 3600.0 * (status.time - status.begin) / status.seconds
    left = 3600.0 * (status.until - status.time) / speed if speed > 0.0 else math.inf
    duration = f"{left / 3600.0:.1f} h" if left > 3600.0 else f"{left / 60.0:.1f} min"
    return f"{speed:.3g} r0/U per hour, {duration} left, eps {status.eps:.3g} r0"
