"""The meridian cross-section of the steady cells in their tube."""

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from celltrain.meridian.geometry import meridian_points
from celltrain.pictures.style import INK, in_style
from celltrain.steady import Base

CELLS = 3
MARGIN = 0.35
FILL = "#C9302C"
EDGE = "#7A1210"
WALL = "0.55"


@in_style()
def draw_profile(base: Base) -> Figure:
    """Three cells cut along the tube's axis, with wall, separation and largest radius."""
    train = base.train
    half = np.stack(meridian_points(base.profile), axis=-1)
    closed = np.concatenate([half, half[::-1] * [-1.0, 1.0]])
    shifts = train.period * (np.arange(CELLS) - (CELLS - 1) / 2)
    middle = 0.5 * (closed[:, 1].min() + closed[:, 1].max())
    reach = 0.5 * CELLS * train.period
    start = min(middle - reach, float(closed[:, 1].min() + shifts[0]) - MARGIN)
    end = max(middle + reach, float(closed[:, 1].max() + shifts[-1]) + MARGIN)
    wall, thickness = train.radius, 0.09 * train.tube.diameter

    # Wide enough to write on, and not so tall that wide tubes fill the page.
    aspect = (end - start) / (2 * (wall + thickness))
    width = min(10.0, max(5.0, 4.2 * aspect + 1.2))
    figure = Figure(figsize=(width, 4.4), layout="constrained")
    axes = figure.add_subplot()
    axes.set_aspect("equal")
    for side in (-1, 1):
        axes.fill_between(
            [start, end],
            side * wall,
            side * (wall + thickness),
            facecolor="0.92",
            edgecolor=WALL,
            hatch="////",
            linewidth=0,
        )
        axes.plot([start, end], [side * wall, side * wall], color="0.25", linewidth=1.2)
    axes.plot([start, end], [0, 0], color="0.6", linewidth=0.7, dashes=(10, 3, 2, 3), zorder=4)
    for shift in shifts:
        axes.fill(
            closed[:, 1] + shift,
            closed[:, 0],
            facecolor=FILL,
            edgecolor=EDGE,
            linewidth=1.4,
            joinstyle="round",
            zorder=3,
        )
    _separation(axes, base, half, float(shifts[0]))
    _largest_radius(axes, base, half, float(shifts[-1]))
    axes.set_xlim(start, end)
    axes.set_ylim(-wall - thickness, wall + thickness)
    axes.set_xlabel("$z$ ($r_0$)")
    axes.set_ylabel("$x$ ($r_0$)")
    axes.set_title(
        f"$D$ = {train.tube.diameter:g} $r_0$, $\\phi$ = {train.packing:g}\n"
        f"flow from left to right, cells at {base.cell_velocity:.4g} $U$",
    )
    return figure


def _separation(axes: Axes, base: Base, half: Float[np.ndarray, "point 2"], shift: float) -> None:
    """An arrow between two cells where their streamwise separation is least."""
    radius, axial = half.T
    # Front and rear of the cell over radius: the largest and least z in each of many rings.
    edges = np.linspace(0.0, radius.max() * (1 + 1e-9), 60)
    ring = np.digitize(radius, edges) - 1
    front, rear = np.full(59, -np.inf), np.full(59, np.inf)
    np.maximum.at(front, ring, axial)
    np.minimum.at(rear, ring, axial)
    with np.errstate(invalid="ignore"):
        closest = int(np.argmax(np.where(np.isfinite(front), front - rear, -np.inf)))
    height = 0.5 * (edges[closest] + edges[closest + 1])
    if closest <= 1:
        height = 0.0
    ends = (front[closest] + shift, rear[closest] + shift + base.train.period)
    axes.annotate(
        "",
        (ends[0], height),
        xytext=(ends[1], height),
        arrowprops={
            "arrowstyle": "<|-|>",
            "color": INK,
            "linewidth": 1.1,
            "shrinkA": 0,
            "shrinkB": 0,
            "mutation_scale": 10 if ends[1] - ends[0] > 0.4 else 4,
        },
        zorder=5,
    )
    # Above the cells, where there is room however close they are.
    middle = 0.5 * (ends[0] + ends[1])
    above = 0.5 * (base.largest_radius + base.train.radius)
    axes.plot([middle, middle], [height, above - 0.22], color=INK, linewidth=0.6, zorder=2)
    axes.text(
        middle,
        above,
        rf"$\Delta$ = {base.gap:.3g} $r_0$",
        ha="center",
        va="center",
        color=INK,
        fontsize=10,
    )


def _largest_radius(
    axes: Axes, base: Base, half: Float[np.ndarray, "point 2"], shift: float
) -> None:
    """The largest radius, written below the rim of a cell."""
    place = float(half[np.argmax(half[:, 0]), 1]) + shift
    axes.annotate(
        rf"$r_\mathrm{{max}}$ = {base.largest_radius:.3f} $r_0$",
        (place, -base.largest_radius),
        xytext=(place, -0.5 * (base.largest_radius + base.train.radius)),
        arrowprops={"arrowstyle": "-|>", "color": INK, "linewidth": 0.8, "mutation_scale": 8},
        ha="center",
        va="center",
        color=INK,
        fontsize=10,
    )
