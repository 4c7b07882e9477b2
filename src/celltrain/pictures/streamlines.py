"""Streamlines around the cells of a steady train, as seen from the cells (Fig. 7)."""

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from celltrain.diagnostics.flow_lines import Streamlines
from celltrain.diagnostics.streamlines import AT_REST, MeridionalFlow, recirculation
from celltrain.meridian.geometry import meridian_points
from celltrain.pictures.style import BLUE, in_style
from celltrain.steady import Base

MEMBRANE, INSIDE, TURNING_COLOR, TURNING_SHADE = "#B3150F", "#E9B7AE", BLUE, "#CFE3F1"
#: Fluid is shaded from this part of the largest stream function on.
SHADED = 3e-3


@in_style()
def draw_streamlines(base: Base, flow: MeridionalFlow) -> Figure:
    """Two periods of a train cut along the axis, streamlines in the frame of the cells.

    Shaded, with blue lines: fluid that turns back between two cells. Dots: points of rest on the
    axis.
    """
    period, radius = base.train.period, base.train.radius
    figure = Figure(figsize=(4.0 * period / radius + 1.5, 4.6), layout="constrained")
    axes = figure.subplots()
    found = recirculation(base, flow)
    streamline_panel(axes, flow, np.stack(meridian_points(base.profile)), found.stagnation_points)
    axes.set_title(
        f"packing {base.train.packing:g}\non the axis between cells {found.axis_velocity:+.2g} $U$",
        loc="left",
        fontsize=9,
    )
    return figure


def streamline_panel(
    axes: Axes,
    flow: MeridionalFlow,
    outline: Float[np.ndarray, "2 point"],
    stagnation_points: tuple[float, ...] = (),
) -> None:
    """Two periods of a train with the streamlines of a flow, as `draw_streamlines` has them.

    **Arguments:** `stagnation_points`: places of rest on the axis, r0 from the middle between two
    cells.
    """
    lines = Streamlines(flow, outline)
    period, radius = lines.period, float(flow.radius[-1])
    stream = np.where(flow.inside, 0.0, flow.stream_function)
    whole = float(np.abs(flow.stream_function[:, -1]).max())
    passing, turning = list(lines.passing()), list(lines.turning())
    across, along = outline
    shade = max(SHADED * float(stream.max()), 0.3 * AT_REST * whole)
    for image in (-1, 0, 1, 2):
        for sign in (1.0, -1.0):
            if stream.max() > AT_REST * whole:
                axes.contourf(
                    flow.axial + image * period,
                    sign * flow.radius,
                    stream.T,
                    levels=[shade, np.inf],
                    colors=[TURNING_SHADE],
                    zorder=0.5,
                )
            for each, color in ((passing, "0.45"), (turning, TURNING_COLOR)):
                for height, distance in each:
                    axes.plot(
                        height + image * period,
                        sign * distance,
                        color=color,
                        linewidth=0.8,
                        zorder=1,
                    )
            place = along + image * period
            axes.fill(place, sign * across, color=INSIDE, zorder=2, linewidth=0)
            axes.plot(place, sign * across, color=MEMBRANE, linewidth=1.6, zorder=3)
    axes.plot(
        [0.5 * period + place for place in stagnation_points],
        [0.0] * len(stagnation_points),
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
    axes.set_xlabel("$z/r_0$")
    axes.set_ylabel("$r/r_0$")
