"""Streamlines around the cells of a steady train, as seen from the cells (Fig. 7)."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from celltrain.diagnostics.streamlines import MeridionalFlow, recirculation
from celltrain.meridian.geometry import meridian_points
from celltrain.steady import Base

# Levels of the stream function over that at the wall: few where fluid passes, more where it turns.
PASSING = np.array([0.8, 0.5, 0.25, 0.1, 0.03, 0.01, 0.003])
TURNING = np.array([0.0, 0.2, 0.4, 0.6, 0.8, 0.95])
MEMBRANE, INSIDE, TURNING_COLOR = "#B3150F", "#E9B7AE", "#0072B2"


def draw_streamlines(base: Base, flow: MeridionalFlow, path: Path) -> Path:
    """Two periods of a train cut along the axis, streamlines in the frame of the cells.

    Blue: streamlines along which fluid turns around the axis between two cells, the outermost
    being the surface psi = 0 that separates it from the fluid that passes. Dots: points of rest on
    the axis.

    **Raises:** `OSError` if the picture cannot be written.
    """
    period, radius = base.train.period, base.train.radius
    figure = Figure(figsize=(4.0 * period / radius + 1.5, 4.6), dpi=200, layout="constrained")
    axes = figure.subplots()
    stream = np.where(flow.inside, np.nan, flow.stream_function)
    whole = float(np.abs(flow.stream_function[:, -1]).max())
    largest = float(np.nanmax(stream))
    found = recirculation(base, flow)
    outline = meridian_points(base.profile)
    for image in (0, 1):
        z = flow.axial + image * period
        for sign in (1.0, -1.0):
            axes.contour(
                z,
                sign * flow.radius,
                stream.T,
                levels=np.sort(-PASSING * whole),
                colors="0.45",
                linewidths=0.7,
                linestyles="solid",
            )
            if found.strength > 0.0:
                axes.contour(
                    z,
                    sign * flow.radius,
                    stream.T,
                    levels=TURNING * largest,
                    colors=TURNING_COLOR,
                    linewidths=0.9,
                    linestyles="solid",
                )
            across, along = outline
            axes.fill(along + image * period, sign * across, color=INSIDE, zorder=2)
            axes.plot(
                along + image * period, sign * across, color=MEMBRANE, linewidth=1.6, zorder=3
            )
    between = 0.5 * period
    axes.plot(
        [between + place for place in found.stagnation_points],
        [0.0] * len(found.stagnation_points),
        "o",
        color="0.1",
        markersize=4,
        zorder=4,
    )
    for side in (-radius, radius):
        axes.axhline(side, color="0.1", linewidth=2.0)
    axes.set_xlim(-0.5 * period, 1.5 * period)
    axes.set_ylim(-1.04 * radius, 1.04 * radius)
    axes.set_aspect("equal")
    axes.set_xlabel("$z$ ($r_0$)")
    axes.set_ylabel("distance from the axis ($r_0$)")
    axes.set_title(
        f"packing {base.train.packing:g}\non the axis between cells {found.axis_velocity:+.2g} $U$",
        loc="left",
        fontsize=9,
    )
    axes.tick_params(direction="in", top=True, right=True)
    figure.savefig(path)
    return path
