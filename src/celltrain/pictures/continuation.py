"""Branches of steady trains, boundaries of stability, and the trains that a search has found."""

import textwrap

import numpy as np
from matplotlib.figure import Figure

from celltrain.continuation import Branch, BranchSearch, StabilityBoundary
from celltrain.meridian.geometry import meridian_points
from celltrain.pictures.style import (
    BLUE,
    COLORS,
    GREEN,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    in_style,
)

#: Trains beyond these are counted, not drawn.
MOST_SHAPES = 7
# Letters of a title on an inch.
LETTERS = 12
EDGES = ("#7A1210", BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION, "0.4")


@in_style()
def draw_branch(branch: Branch) -> Figure:
    """Cell velocity, gap, and the growth rate if it is known, over the parameter; folds marked."""
    values = np.array([point.value for point in branch.points])
    columns = [
        ("cell velocity $U_c$ ($U$)", np.array([p.base.cell_velocity for p in branch.points])),
        (r"gap $\Delta$ ($r_0$)", np.array([p.base.gap for p in branch.points])),
    ]
    growth = np.array([point.growth_rate for point in branch.points])
    if np.isfinite(growth).any():
        columns.append((r"growth rate $\alpha$ ($U/r_0$)", growth))
    figure = Figure(figsize=(4.2 * len(columns), 3.8), layout="constrained")
    folds = list(branch.folds)
    for axes, (label, numbers) in zip(figure.subplots(1, len(columns)), columns, strict=True):
        axes.plot(values, numbers, color=BLUE, marker="o", markersize=3.5, linewidth=1.3)
        axes.plot(values[folds], numbers[folds], "s", color=VERMILION, markersize=7, zorder=4)
        axes.set_xlabel(branch.parameter.replace("_", " "))
        axes.set_ylabel(label)
        if numbers is growth:
            axes.axhline(0.0, color="0.3", linewidth=0.8, zorder=1)
    return figure


@in_style()
def draw_stability_boundary(boundaries: dict[str, StabilityBoundary]) -> Figure:
    """Curves alpha = 0, one for each named mode; arrows point into its unstable side."""
    figure = Figure(figsize=(5.6, 4.4), layout="constrained")
    axes = figure.add_subplot()
    places = np.array(
        [[p.diameter, p.packing] for each in boundaries.values() for p in each.points]
    )
    # Directions as they look: both axes in parts of what is drawn.
    size = np.maximum(np.ptp(places, axis=0), 0.02 * np.abs(places).max(axis=0))
    for number, (name, boundary) in enumerate(boundaries.items()):
        color = COLORS[number % len(COLORS)]
        curve = np.array([[point.diameter, point.packing] for point in boundary.points])
        axes.plot(*curve.T, "o-", color=color, markersize=4, label=name)
        for point, place in zip(boundary.points, curve, strict=True):
            uphill = size * point.gradient
            uphill = 0.06 * size * uphill / np.linalg.norm(uphill)
            axes.annotate(
                "", place + uphill, place, arrowprops={"arrowstyle": "->", "color": color}
            )
    axes.margins(0.12)
    axes.set_xlabel("diameter $D$ ($r_0$)")
    axes.set_ylabel(r"packing $\phi$")
    axes.legend()
    return figure


@in_style()
def draw_search(search: BranchSearch) -> Figure:
    """A cell of the known train and of each further one, cut along the axis, front to the right."""
    trains = [("known", search.known)]
    trains += [(f"further {i}", each.base) for i, each in enumerate(search.found[:MOST_SHAPES], 1)]
    figure = Figure(figsize=(max(5.0, 2.6 * len(trains)), 3.9), layout="constrained")
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
    panels[0].set_ylabel("$x$ ($r_0$)")
    width = int(LETTERS * figure.get_figwidth())
    figure.suptitle(textwrap.fill(search.statement, width), fontsize=10)
    return figure
