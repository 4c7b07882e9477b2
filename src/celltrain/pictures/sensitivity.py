"""Where on the membrane the eigenvalue of a mode is made."""

from pathlib import Path

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from celltrain.pictures.style import BLUE, VERMILION
from celltrain.stability import StructuralSensitivity


def draw_structural_sensitivity(result: StructuralSensitivity, path: Path) -> Path:
    """The sensitivity as colour on the cell's outline, and mode, adjoint and product over theta.

    Raises:
        OSError: if the picture cannot be written.
    """
    figure = Figure(figsize=(10.0, 4.2), dpi=200, layout="constrained")
    cell, lines = figure.subplots(1, 2, width_ratios=[1.0, 1.5])
    colored = None
    for sign in (1.0, -1.0):
        points = np.stack([result.axial, sign * result.radius], axis=-1)
        pieces = np.stack([points[:-1], points[1:]], axis=1)
        colored = LineCollection(list(pieces), array=result.sensitivity[:-1], linewidths=5.0)
        colored.set_cmap("inferno")
        colored.set_clim(0.0, float(result.sensitivity.max()))
        cell.add_collection(colored)
    assert colored is not None
    figure.colorbar(colored, ax=cell, label="structural sensitivity, per solid angle")
    cell.autoscale_view()
    cell.margins(0.08)
    cell.set_aspect("equal")
    cell.set_xlabel("$z$ ($r_0$)")
    cell.set_ylabel("distance from the axis ($r_0$)")
    degrees = np.degrees(result.theta)
    for values, name, color in (
        (result.direct, "mode $|r|$", BLUE),
        (result.adjoint, "adjoint $|l|$", VERMILION),
        (result.sensitivity, "their product over $|<l, r>|$", "0.15"),
    ):
        lines.plot(degrees, values / values.max(), label=name, color=color, linewidth=1.5)
    lines.set_xlim(0.0, 180.0)
    lines.set_ylim(0.0, 1.05)
    lines.set_xlabel(r"$\theta$ (degrees; 0 is the front)")
    lines.set_ylabel("relative to the largest")
    lines.legend(fontsize=9, frameon=False)
    mode = result.mode
    lines.set_title(
        f"$m$ = {mode.azimuthal_number}, $j$ = {mode.wave_number}, growth rate"
        f" {mode.growth_rate:.3g} $U/r_0$; integral {result.integral:.3g}",
        loc="left",
        fontsize=10,
    )
    for axes in (cell, lines):
        axes.tick_params(direction="in", top=True, right=True)
    figure.savefig(path)
    return path
