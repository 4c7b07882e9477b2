"""A branch of steady trains over its parameter."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from celltrain.continuation import Branch
from celltrain.pictures.style import BLUE, VERMILION


def draw_branch(branch: Branch, path: Path) -> Path:
    """Cell velocity, gap, and the growth rate if it is known, over the parameter; folds marked.

    Raises:
        OSError: if the picture cannot be written.
    """
    values = np.array([point.value for point in branch.points])
    columns = [
        ("cell velocity $U_c$ ($U$)", np.array([p.base.cell_velocity for p in branch.points])),
        (r"gap $\Delta$ ($r_0$)", np.array([p.base.gap for p in branch.points])),
    ]
    growth = np.array([point.growth_rate for point in branch.points])
    if np.isfinite(growth).any():
        columns.append((r"growth rate $\alpha$ ($U/r_0$)", growth))
    figure = Figure(figsize=(4.2 * len(columns), 3.8), dpi=200, layout="constrained")
    folds = list(branch.folds)
    for axes, (label, numbers) in zip(figure.subplots(1, len(columns)), columns, strict=True):
        axes.plot(values, numbers, color=BLUE, marker="o", markersize=3.5, linewidth=1.3)
        axes.plot(values[folds], numbers[folds], "s", color=VERMILION, markersize=7, zorder=4)
        axes.set_xlabel(branch.parameter.replace("_", " "))
        axes.set_ylabel(label)
        axes.tick_params(direction="in", top=True, right=True)
        if numbers is growth:
            axes.axhline(0.0, color="0.3", linewidth=0.8, zorder=1)
    figure.savefig(path)
    return path
