"""How a growth rate changes with the parameters, and where on the membrane it is made."""

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from celltrain.pictures.style import BLUE, GREEN, PURPLE, VERMILION, color_bar, in_style
from celltrain.stability import ParameterSensitivities, StructuralSensitivity


@in_style()
def draw_structural_sensitivity(result: StructuralSensitivity) -> Figure:
    """The sensitivity as colour on the cell's outline, and mode, adjoint and product over theta."""
    figure = Figure(figsize=(10.0, 4.2), layout="constrained")
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
    color_bar(cell, colored, "structural sensitivity, per solid angle")
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
    lines.legend()
    mode = result.mode
    lines.set_title(
        f"$m$ = {mode.azimuthal_number}, $j$ = {mode.wave_number}, growth rate"
        f" {mode.growth_rate:.3g} $U/r_0$; integral {result.integral:.3g}",
    )
    return figure


@in_style()
def draw_parameter_sensitivities(result: ParameterSensitivities) -> Figure:
    """Bars for each parameter p: d alpha/d log p, and d log(U_c, mu_eff)/d log p."""
    figure = Figure(figsize=(10.0, 4.0), layout="constrained")
    modal, steady = figure.subplots(1, 2, sharey=True)
    entries = list(result.entries.values())
    places = np.arange(len(entries))[::-1]
    growth = np.array([entry.relative for entry in entries])
    modal.barh(places, growth, height=0.6, color=np.where(growth > 0.0, VERMILION, BLUE))
    mode = result.mode
    modal.set_title(
        rf"(a) $m$ = {mode.azimuthal_number}, $q$ = {mode.phase / np.pi:.3g} $\pi$,"
        rf" $\alpha$ = {mode.growth_rate:.3g} $U/r_0$",
    )
    modal.set_xlabel(r"$\partial \alpha/\partial \log p$  ($U/r_0$)")
    modal.set_yticks(places, [entry.parameter.replace("_", " ") for entry in entries])
    base = result.base
    for offset, name, color, values in (
        (0.17, "cell velocity", GREEN, _logarithmic(result, "cell_velocity")),
        (-0.17, "effective viscosity", PURPLE, _logarithmic(result, "effective_viscosity")),
    ):
        steady.barh(places + offset, values, height=0.32, color=color, label=name)
    steady.set_xlabel(r"$\partial \log(\cdot)/\partial \log p$")
    steady.set_title(
        rf"(b) steady train: $U_c$ = {base.cell_velocity:.4g} $U$, $\mu_\mathrm{{eff}}$ ="
        rf" {base.effective_viscosity:.4g} $\mu$",
    )
    steady.legend()
    for axes in (modal, steady):
        axes.axvline(0.0, color="0.3", linewidth=0.8)
    return figure


def _logarithmic(result: ParameterSensitivities, quantity: str) -> list[float]:
    scale = getattr(result.base, quantity)
    return [
        entry.value * getattr(entry.base, quantity) / scale for entry in result.entries.values()
    ]
