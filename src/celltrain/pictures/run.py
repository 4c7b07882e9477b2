"""All pictures of a simulation, and its film."""

from functools import partial
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int
from matplotlib.figure import Figure

from celltrain.contract import Draw
from celltrain.evolution import Run
from celltrain.pictures.animation import FilmProgress, animate
from celltrain.pictures.evolution import Growth, draw_snapshots, plot_growth
from celltrain.pictures.record import draw_record

# Pictures one below the other, and pictures of a film, about half a second each.
SNAPSHOTS = 6
MOST_FILM_FRAMES = 150


def run_pictures(run: Run) -> dict[str, Draw]:
    """How every picture of a simulation is drawn, by its name.

    The growth of the disturbance beside linear theory over time and over its logarithm (Figs. 11
    and 4), the cells at a few times from the beginning to the end (Fig. 12), and what was recorded
    of them. Of a simulation that has only begun, those that it is long enough for.
    """
    found: dict[str, Draw] = {}
    if len(run.history["time"]) >= 3:
        grown = partial(plot_growth, run.train, run_growth(run))
        found |= {"growth": grown, "growth_log_time": partial(grown, logarithmic_time=True)}
    found["snapshots"] = partial(_snapshots, run)
    if len(run.times) >= 2:
        found["record"] = partial(draw_record, run)
    return found


def _snapshots(run: Run) -> Figure:
    chosen = spread(len(run.times), SNAPSHOTS)
    velocities = relative_velocities(run)[chosen]
    return draw_snapshots(run.train, run.times[chosen], run.shapes[chosen], velocities=velocities)


def animate_run(run: Run, path: Path, *, progress: FilmProgress | None = None) -> Path:
    """Write a simulation as a film of at most `MOST_FILM_FRAMES` of its frames; returns `path`.

    **Raises:** as `animate`.
    """
    chosen = spread(len(run.times), MOST_FILM_FRAMES)
    return animate(run.train, run.times[chosen], run.shapes[chosen], path, progress=progress)


def run_growth(run: Run) -> Growth:
    """How the disturbance of a simulation went, and what linear theory says of it."""
    history, linear = run.history, run.history["eps_linear"]
    return Growth(
        history["time"],
        history["eps"],
        history["eps_x"],
        run.growth_rate if np.isfinite(run.growth_rate) else None,
        linear if np.isfinite(linear).all() else None,
    )


def relative_velocities(run: Run) -> Float[np.ndarray, "frame cell 3"]:
    """Velocities of the centroids in all frames relative to the steady train, in U."""
    velocities = run.frames["centroid_velocity"].copy()
    velocities[..., 2] -= run.base.cell_velocity
    return velocities


def spread(count: int, most: int) -> Int[np.ndarray, " chosen"]:
    """At most so many of `count` numbers from 0, first and last included, evenly spread."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int))
