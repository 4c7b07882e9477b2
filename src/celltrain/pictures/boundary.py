"""Boundaries of stability in the plane of diameter and packing."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from celltrain.continuation import StabilityBoundary
from celltrain.pictures.style import COLORS


def draw_stability_boundary(boundaries: dict[str, StabilityBoundary], path: Path) -> Path:
    """Curves alpha = 0, one for each named mode; arrows point into its unstable side.

    Raises:
        OSError: if the picture cannot be written.
    """
    figure = Figure(figsize=(5.6, 4.4), dpi=200, layout="constrained")
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
    axes.tick_params(direction="in", top=True, right=True)
    axes.legend(fontsize=9, frameon=False)
    figure.savefig(path)
    return path
