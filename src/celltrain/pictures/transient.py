"""Transient growth over time, and the cell before and after it."""

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from celltrain.harmonics import degree_of, real_harmonics
from celltrain.pictures.spectrum import number_color
from celltrain.pictures.style import COLORS, INK, ORANGE, SKY, in_style
from celltrain.stability import TransientGrowth

# Largest displacement of the outlines drawn, in r0.
DISPLACEMENT = 0.25


@in_style()
def draw_transient_growth(growth: TransientGrowth) -> Figure:
    """G(t), its bounds and two disturbances over time; the optimal one's cell, cut along the axis.

    The outlines are the first cell before (dashed: the steady one) and after, both with the same
    largest displacement; how much the disturbance has grown stands above.
    """
    figure = Figure(figsize=(11.0, 4.4), layout="constrained")
    curves, before, after = figure.subplots(1, 3, width_ratios=[2.2, 1.0, 1.0])
    _curves(curves, growth)
    optimal = growth.optimal
    shape = growth.result.base.coefficients
    initial, final = optimal.shapes(growth.result)
    j, cells = optimal.wave_number, growth.result.base.train.cells
    _outline(before, shape, initial[0], "before")
    _outline(
        after, shape, final[0], f"after {optimal.time:.3g} $r_0/U$: {optimal.growth:.3g} times"
    )
    before.set_xlabel(f"optimal: $m$ = {optimal.azimuthal_number}, $q$ = 2$\\pi$ {j}/{cells}")
    return figure


def _curves(axes: Axes, growth: TransientGrowth) -> None:
    times = growth.times
    seen = times > 0.0
    for m in sorted({block.azimuthal_number for block in growth.blocks})[: len(COLORS)]:
        best = np.max([b.growth for b in growth.blocks if b.azimuthal_number == m], axis=0)
        color = number_color(m)
        axes.plot(times[seen], best[seen], color=color, linewidth=1.3, label=f"$m$ = {m}")
    whole = growth.growth
    axes.plot(
        times[seen], whole[seen], color=INK, linewidth=2.4, alpha=0.35, label="largest of all, $G$"
    )
    top = 1.3 * float(whole.max())
    for rate, name, dashes in (
        (growth.numerical_abscissa, r"$e^{\eta t}$", (1, 1.6)),
        (growth.spectral_abscissa, r"$e^{\alpha t}$", (5, 2)),
    ):
        bound = np.exp(np.minimum(rate * times, np.log(10.0 * top)))
        axes.plot(
            times[seen], bound[seen], color=INK, linewidth=1.0, linestyle=(0, dashes), label=name
        )
    for values, name, color in (
        (growth.abrupt, r"$|e^{At} v_\eta|$", ORANGE),
        (growth.modal, r"$|e^{At} v_\alpha|$", SKY),
    ):
        axes.plot(times[seen], values[seen], color=color, linewidth=1.3, label=name)
    optimal = growth.optimal
    if optimal.time > 0.0:
        axes.plot(optimal.time, optimal.growth, "*", markersize=12, color=INK, zorder=5)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_ylim(max(0.5 * float(min(growth.abrupt.min(), 1.0)), 0.05), top)
    axes.set_xlim(times[seen][0], times[-1])
    axes.set_xlabel("$t$ ($r_0/U$)")
    axes.set_ylabel(f"growth in the norm {growth.norm}")
    axes.legend(fontsize=8, frameon=False, ncols=2, loc="upper left")


def _outline(
    axes: Axes,
    shape: Float[np.ndarray, "3 coefficient"],
    disturbance: Float[np.ndarray, "3 coefficient"],
    title: str,
) -> None:
    """A cell in the plane of z and x, steady and disturbed."""
    theta = np.linspace(0.0, 2.0 * np.pi, 721)
    polar = np.where(theta <= np.pi, theta, 2.0 * np.pi - theta)
    longitude = np.where(theta <= np.pi, 0.0, np.pi)
    values = real_harmonics(degree_of(shape), polar, longitude).T
    rest, moved = shape @ values, disturbance @ values
    largest = float(np.linalg.norm(moved, axis=0).max())
    # A swirl does not show in this plane.
    scale = DISPLACEMENT / largest if largest > 1e-9 else 0.0
    drawn = rest + scale * moved
    axes.plot(rest[2], rest[0], color="0.5", linewidth=1.0, linestyle=(0, (4, 3)))
    axes.plot(drawn[2], drawn[0], color="#B3150F", linewidth=1.8)
    axes.axhline(0.0, color="0.85", linewidth=0.8, zorder=0)
    axes.set_aspect("equal")
    axes.set_title(title, loc="left", fontsize=9)
    axes.set_ylabel("$x$ ($r_0$)")
