"""The shapes of the steady trains that a search has found."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from celltrain.continuation import BranchSearch
from celltrain.meridian.geometry import meridian_points
from celltrain.pictures.style import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION

#: Trains beyond these are counted, not drawn.
MOST_SHAPES = 7
EDGES = ("#7A1210", BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION, "0.4")


def draw_search(search: BranchSearch, path: Path) -> Path:
    """One cell of the known train and of every further one, cut along the axis, front to the right.

    Raises:
        OSError: if the picture cannot be written.
    """
    trains = [("known", search.known)]
    trains += [(f"further {i}", each.base) for i, each in enumerate(search.found[:MOST_SHAPES], 1)]
    figure = Figure(figsize=(max(5.0, 2.6 * len(trains)), 3.9), dpi=200, layout="constrained")
    panels = figure.subplots(1, len(trains), sharey=True, squeeze=False)[0]
    wall = search.known.train.radius
    for axes, edge, (name, base) in zip(panels, EDGES, trains, strict=False):
        half = np.stack(meridian_points(base.profile), axis=-1)
        closed = np.concatenate([half, half[::-1] * [-1.0, 1.0]])
        axes.fill(closed[:, 1], closed[:, 0], facecolor=edge, alpha=0.25)
        axes.plot(closed[:, 1], closed[:, 0], color=edge, linewidth=1.4)
        for side in (-wall, wall):
            axes.axhline(side, color="0.25", linewidth=1.2)
        axes.set_aspect("equal")
        axes.set_xlabel("$z$ ($r_0$)")
        axes.set_title(f"{name}\n$U_c$ = {base.cell_velocity:.4f} $U$", fontsize=9, loc="left")
        axes.tick_params(direction="in", top=True, right=True)
    panels[0].set_ylabel("$x$ ($r_0$)")
    figure.suptitle(search.statement, fontsize=10)
    figure.savefig(path)
    return path
