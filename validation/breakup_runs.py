"""The simulations of a breakup: what they are, marching them, and what is kept of them.

The files of the simulations stay out of the repository; of each a summary of a few hundred numbers
and a picture are kept beside the page.
"""

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from page import DOTS_PER_INCH, FOLDER

from celltrain import CaseError, Run, Train, evolve, paper_units, resume, stability, steady
from celltrain.cli.progress import Reporter
from celltrain.contract import presentation
from celltrain.evolution import Disturbance, Leading, RandomDisplacement
from celltrain.evolution.record.recompute import pressure_drops
from celltrain.pictures.evolution import draw_snapshots
from celltrain.pictures.run import relative_velocities, spread

#: Times of the paper's Fig. 12 and of its text, r0/U.
PAPER_TIMES = tuple(
    paper_units.time_from_paper(time) for time in (0.0, 61.0, 72.0, 97.0, 108.0, 141.0)
)
EVERY = 5.0
# That of the paper's Fig. 11.
AMPLITUDE = 0.1
DENSE = Train(diameter=10, packing=0.7, cells=8, degree=12)
LONGER = DENSE.changed(cells=12)
# Eight cells in the tube of those twelve.
SPARSE = DENSE.changed(packing=DENSE.packing * DENSE.cells / LONGER.cells)
# Times kept in a summary, and significant digits.
KEPT_TIMES = 50
DIGITS = 5
# How far (relative) eps_x may be from exponential growth and still be said to follow it.
CLOSE = 0.2


@dataclass(frozen=True)
class Case:
    """One simulation: what it shows, the train, what is done to it, and until when (r0/U)."""

    shows: str
    train: Train
    disturbance: Disturbance
    until: float


CASES: dict[str, Case] = {
    "leading": Case("the fastest mode, Figs. 11 and 12", DENSE, Leading(AMPLITUDE), 2000.0),
    "random": Case("the ad hoc disturbance, Fig. 11", DENSE, RandomDisplacement(AMPLITUDE), 600.0),
    "sparse": Case(
        "the fastest mode of a sparse train, Fig. 11",
        DENSE.changed(packing=0.2),
        Leading(AMPLITUDE),
        350.0,
    ),
    "eight": Case("eight cells in a tube, Fig. 1a", SPARSE, RandomDisplacement(0.5), 1000.0),
    "twelve": Case("twelve in the same tube, Fig. 1b", LONGER, RandomDisplacement(0.5), 600.0),
}


def simulate(name: str, path: Path) -> None:
    """Run a simulation, or go on with its file, until its end; killed, it may be gone on with."""
    case = CASES[name]
    if path.exists():
        until = max(case.until, float(load(name, path).times[-1]))
        with Reporter() as progress:
            resume(path, until=until, progress=progress.step)
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    with Reporter() as reporter:
        base = steady(case.train, progress=reporter.iteration)
        start = stability(base, estimate_error=False, progress=reporter.share)
    with Reporter() as progress:
        evolve(
            start,
            case.disturbance,
            until=case.until,
            every=EVERY,
            path=path,
            progress=progress.step,
        )


def load(name: str, path: Path) -> Run:
    """A simulation's file.

    **Raises:** `CaseError` if it is that of another case.
    """
    run, case = Run.load(path), CASES[name]
    if run.train != case.train or run.disturbance != str(case.disturbance):
        raise CaseError(
            f"{str(path)!r} is not allowed as {name!r}: it is {run.disturbance} of another train,"
            f" or another one than {case.disturbance}"
        )
    return run


def summarise(name: str, path: Path) -> dict[str, Any]:
    """What the page needs of a simulation: from its file, or else as it was kept before.

    From a file, summary and picture are kept anew. Empty if there is neither.
    """
    kept = FOLDER / f"breakup-{name}.json"
    if not path.exists():
        return json.loads(kept.read_text()) if kept.exists() else {}
    run = load(name, path)
    content = summary(run)
    FOLDER.mkdir(parents=True, exist_ok=True)
    lines = [f" {json.dumps(key)}: {json.dumps(value)}" for key, value in content.items()]
    kept.write_text("{\n" + ",\n".join(lines) + "\n}\n")
    chosen = snapshot_frames(run.times)
    draw_snapshots(
        run.train,
        run.times[chosen],
        run.shapes[chosen],
        velocities=relative_velocities(run)[chosen],
        dots_per_inch=DOTS_PER_INCH,
    ).savefig(FOLDER / f"breakup-{name}.png")
    return content


def snapshot_frames(times: np.ndarray) -> np.ndarray:
    """The frames at the paper's times, or evenly spread ones where few of these are reached."""
    reached = [time for time in PAPER_TIMES if time <= times[-1]]
    if len(reached) < 4:
        return spread(len(times), 4)
    return np.array([int(np.abs(times - time).argmin()) for time in reached])


def summary(run: Run) -> dict[str, Any]:
    """A simulation in a few hundred numbers, r0, U and mu."""
    measures = order_measures(run) | {
        "extra_pressure_drop": pressure_drops(run) - 1.0,
        "eps": run.frames["eps"],
        "eps_x": run.frames["eps_x"],
        "cell_distance": run.frames["cell_distance"].min(axis=1),
        "wall_distance": run.frames["wall_distance"].min(axis=1),
        "energy": sum(
            run.frames[f"energy_{part}"].sum(axis=1) for part in ("shear", "dilatation", "bending")
        ),
        "film_share": np.interp(run.times, run.history["time"], run.history["film_energy"])
        / np.interp(run.times, run.history["time"], run.history["energy"]),
    }
    chosen = sorted({*spread(len(run.times), KEPT_TIMES), *snapshot_frames(run.times)})
    return {
        **presentation(run.kind).summary(run),
        "cell_velocity": run.base.cell_velocity,
        "events": events(run, measures),
        "times": run.times[chosen].tolist(),
        "measures": {
            name: [float(f"{value:.{DIGITS}g}") for value in np.asarray(column)[chosen]]
            for name, column in measures.items()
        },
    }


def order_measures(run: Run) -> dict[str, np.ndarray]:
    """How much of a train is left, by frame.

    - "spacing": largest deviation of the axial distance of two neighbours from the period, over it
      (cells that are neighbours then);
    - "radial": root mean square distance of the centroids from the axis, r0;
    - "inclination": mean, degrees;
    - "opposition": -1 where neighbours turn alike, +1 where oppositely: minus the sum of the
      products of their rotation rates over that of the squares.
    """
    centroids, rotation = run.frames["centroid"], run.frames["rotation_rate"]
    train = run.train
    apart = np.abs(distances_ahead(run) - train.period).max(axis=1)
    products = np.sum(rotation * np.roll(rotation, -1, axis=1), axis=(1, 2))
    return {
        "spacing": apart / train.period,
        "radial": np.sqrt(np.mean(np.sum(centroids[..., :2] ** 2, axis=-1), axis=1)),
        "inclination": np.rad2deg(run.frames["inclination"]).mean(axis=1),
        "opposition": -products / np.sum(rotation**2, axis=(1, 2)),
    }


def distances_ahead(run: Run) -> np.ndarray:
    """Axial distances [frame, cell] of neighbours' centroids, in the order of then, r0."""
    length = run.train.length
    heights = np.sort(run.frames["centroid"][..., 2] % length, axis=1)
    return np.diff(heights, axis=1, append=heights[:, :1] + length)


def events(run: Run, measures: dict[str, np.ndarray]) -> dict[str, float | None]:
    """When something happened first (r0/U), None for what has not."""
    times, size = run.history["time"], run.history["eps_x"]
    found = {
        "eps_x = 0.5": first_time(times, size > 0.5),
        "eps_x = 1": first_time(times, size > 1.0),
        "out of order": first_time(run.times, measures["spacing"] > 0.5),
    }
    if math.isfinite(run.growth_rate):
        exponential = size[0] * np.exp(run.growth_rate * times)
        found["not exponential"] = first_time(times, np.abs(size / exponential - 1.0) > CLOSE)
    return found


def first_time(times: np.ndarray, happened: np.ndarray) -> float | None:
    """The first of the times at which something is true."""
    return float(times[np.argmax(happened)]) if happened.any() else None


def at(content: dict[str, Any], measure: str, time: float) -> float | None:
    """A measure at the kept time nearest to the given one, None if that is not reached."""
    times = np.array(content["times"])
    if time > times[-1] + 0.5 * EVERY:
        return None
    return float(content["measures"][measure][int(np.abs(times - time).argmin())])
