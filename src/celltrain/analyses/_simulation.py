"""How simulations are shown; `celltrain evolve` computes them."""

import math
from collections.abc import Mapping

import numpy as np
from rich.console import Console

from celltrain.contract import Draw, Presentation
from celltrain.contract.status import ExitStatus
from celltrain.contract.tables import case_line, quantities_table
from celltrain.evolution import Run
from celltrain.evolution.record.repulsion import repulsion_record
from celltrain.results import Plain, plain
from celltrain.results.version import version

_STATUS = {
    **dict.fromkeys(("complete", "steps", "running"), ExitStatus.DONE),
    "interrupted": ExitStatus.INTERRUPTED,
    "not_saved": ExitStatus.NOT_KEPT,
}


class SimulationPresentation(Presentation[Run]):
    """Growth beside theory, the cells at some times, and what was recorded of them."""

    result = Run

    @classmethod
    def summary(cls, result: Run) -> dict[str, Plain]:
        """How it went, in r0, U and mu."""
        history = {name: column[[0, -1]].astype(float) for name, column in result.history.items()}
        method = plain(result.integrator)
        assert isinstance(method, dict)
        content = {
            "version": version(),
            "kind": result.kind,
            "case": result.train,
            "disturbance": result.disturbance,
            "integrator": {"name": type(result.integrator).__name__, **method},
            "repulsion": {**vars(result.repulsion), **repulsion_record(result)},
            "ending": result.ending,
            "time": result.reached,
            "until": result.until,
            "frames": len(result.times),
            "steps": result.steps,
            "rejected": result.work.rejected,
            "evaluations": result.work.evaluations,
            "wall_seconds": history["wall_seconds"][-1],
            "growth_rate": result.growth_rate,
            "eps": [history["eps"][0], result.frames["eps"][-1]],
            "eps_x": [history["eps_x"][0], result.frames["eps_x"][-1]],
            "largest_volume_correction": _correction(result),
        }
        found = plain(content)
        assert isinstance(found, dict)
        return found

    @classmethod
    def report(cls, result: Run, console: Console) -> None:
        """Print how the simulation went."""
        frames, wall = result.frames, float(result.history["wall_seconds"][-1])
        speed = 3600.0 * result.reached / wall if wall > 0.0 else math.nan
        console.print(case_line(result.base))
        table = quantities_table("Simulation", result, {})
        for name, value, unit in (
            ("time reached", f"{result.reached:.6g} of {result.until:.6g}", "r0/U"),
            ("steps (rejected)", f"{result.steps} ({result.work.rejected})", ""),
            ("evaluations of the velocity", f"{result.work.evaluations}", ""),
            ("eps, first and last", _pair(frames["eps"]), "r0"),
            ("eps by the linear dynamics", _pair(frames["eps_linear"]), "r0"),
            ("eps_x, first and last", _pair(frames["eps_x"]), "r0"),
            ("least distance between cells", f"{frames['cell_distance'].min():.4f}", "r0"),
            ("least distance from the wall", f"{frames['wall_distance'].min():.4f}", "r0"),
            ("largest correction of the volume", f"{_correction(result):.1e}", "r0"),
            *_repulsion_rows(result),
            ("speed", f"{speed:.3g}", "r0/U per hour"),
        ):
            table.add_row(name, value, unit)
        table.caption = f"disturbance {result.disturbance}; {result.ending.message}"
        console.print(table)

    @classmethod
    def pictures(cls, result: Run) -> Mapping[str, Draw]:
        """Those for which the simulation is long enough."""
        from celltrain.pictures.run import run_pictures

        return run_pictures(result)

    @classmethod
    def status(cls, result: Run) -> int:
        """0 where the time asked for is reached, 3 where it could not go on."""
        return _STATUS.get(result.ending.kind, ExitStatus.NOT_CONVERGED)


def _correction(run: Run) -> float:
    return float(run.history["volume_correction"][1:].max(initial=0.0))


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


def _pair(values: np.ndarray) -> str:
    first, last = float(values[0]), float(values[-1])
    return "not known" if math.isnan(last) else f"{first:.4g}  {last:.4g}"
