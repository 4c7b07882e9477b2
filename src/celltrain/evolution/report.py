"""A simulation in the terminal: its progress, and what came out."""

import math
from types import TracebackType
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn
from rich.table import Table

from celltrain.evolution.march import Status
from celltrain.evolution.record.run import Run


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


def run_summary(run: Run) -> dict[str, Any]:
    """A run as an object that JSON can hold, in r0, U and mu; None for what is not known."""
    train, history = run.train, run.history
    last = {name: float(column[-1]) for name, column in history.items()}
    content = {
        "case": {**train.sections(), "scales": train.scales.model_dump()},
        "disturbance": run.disturbance,
        "integrator": {"name": type(run.integrator).__name__, **run.integrator.settings()},
        "repulsion": {**run.repulsion.settings(), **repulsion_record(run)},
        "ending": run.ending.kind,
        "message": run.ending.message,
        "time": run.state.time,
        "until": run.until,
        "frames": len(run.times),
        "steps": run.steps,
        "rejected": run.work.rejected,
        "evaluations": run.work.evaluations,
        "wall_seconds": last["wall_seconds"],
        "growth_rate": run.growth_rate,
        "eps": [float(history["eps"][0]), float(run.frames["eps"][-1])],
        "eps_x": [float(history["eps_x"][0]), float(run.frames["eps_x"][-1])],
        "largest_volume_correction": float(history["volume_correction"][1:].max(initial=0.0)),
    }
    return {name: _finite(value) for name, value in content.items()}


def repulsion_record(run: Run) -> dict[str, float]:
    """How much the repulsion acted, as far as the ends of steps tell.

    When it began ("since", r0/U, nan if it did not) and for how long ("duration", r0/U), the
    thinnest film ("smallest_gap", r0, infinite if there was none), the largest force of films on a
    cell (mu U r0) and the largest energy of all films over that of the membranes.
    """
    history = run.history
    acts = np.isfinite(history["gap"])
    return {
        "since": float(history["time"][np.argmax(acts)]) if acts.any() else math.nan,
        "duration": float(history["size"][acts].sum()),
        "smallest_gap": float(history["gap"].min()),
        "largest_force": float(history["film_force"].max()),
        "largest_energy_share": float((history["film_energy"] / history["energy"]).max()),
    }


def _finite(value: Any) -> Any:
    if isinstance(value, list):
        return [_finite(each) for each in value]
    if isinstance(value, dict):
        return {name: _finite(each) for name, each in value.items()}
    return None if isinstance(value, float) and not math.isfinite(value) else value


def print_run(run: Run, console: Console) -> None:
    """Print how a simulation went."""
    history, frames = run.history, run.frames
    table = Table(title="Simulation", title_justify="left", title_style="bold", show_header=False)
    table.add_column("quantity")
    table.add_column("value", justify="right")
    table.add_column("unit", style="dim")
    wall = float(history["wall_seconds"][-1])
    speed = 3600.0 * run.state.time / wall if wall > 0.0 else math.nan
    correction = float(history["volume_correction"][1:].max(initial=0.0))
    table.add_row("time", f"{run.times[-1]:.6g}", "r0/U")
    table.add_row("steps (rejected)", f"{run.steps} ({run.work.rejected})", "")
    table.add_row("evaluations of the velocity", f"{run.work.evaluations}", "")
    table.add_row("eps, first and last", _pair(frames["eps"]), "r0")
    table.add_row("eps by the linear dynamics", _pair(frames["eps_linear"]), "r0")
    table.add_row("eps_x, first and last", _pair(frames["eps_x"]), "r0")
    table.add_row("least distance between cells", f"{frames['cell_distance'].min():.4f}", "r0")
    table.add_row("least distance from the wall", f"{frames['wall_distance'].min():.4f}", "r0")
    table.add_row("largest correction of the volume", f"{correction:.1e}", "r0")
    for name, value, unit in _repulsion_rows(run):
        table.add_row(name, value, unit)
    table.add_row("speed", f"{speed:.3g}", "r0/U per hour")
    table.caption = f"{run.disturbance}; {run.ending.message}"
    table.caption_justify = "left"
    console.print(table)


def _repulsion_rows(run: Run) -> list[tuple[str, str, str]]:
    if run.repulsion.range == 0.0:
        return [("repulsion of membranes", "none", "")]
    record = repulsion_record(run)
    if math.isnan(record["since"]):
        return [("repulsion of membranes", f"never within {run.repulsion.range:g}", "r0")]
    return [
        ("repulsion of membranes, acting for", f"{record['duration']:.4g}", "r0/U"),
        ("thinnest film", f"{record['smallest_gap']:.4f}", "r0"),
        ("largest force of films on a cell", f"{record['largest_force']:.3g}", "mu U r0"),
    ]


def _pair(values: Any) -> str:
    first, last = float(values[0]), float(values[-1])
    return "not known" if math.isnan(last) else f"{first:.4g}  {last:.4g}"
