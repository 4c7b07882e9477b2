"""How a growth rate and the steady train change with the parameters of a train."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from celltrain.pictures.style import BLUE, GREEN, VERMILION
from celltrain.stability import ParameterSensitivities


def draw_parameter_sensitivities(result: ParameterSensitivities, path: Path) -> Path:
    """Bars for each parameter p: d alpha/d log p, and d log(U_c, mu_eff)/d log p.

    Raises:
        OSError: if the picture cannot be written.
    """
    figure = Figure(figsize=(10.0, 4.0), dpi=200, layout="constrained")
    modal, steady = figure.subplots(1, 2, sharey=True)
    entries = list(result.entries.values())
    places = np.arange(len(entries))[::-1]
    growth = np.array([entry.relative for entry in entries])
    modal.barh(places, growth, height=0.6, color=np.where(growth > 0.0, VERMILION, BLUE))
    mode = result.mode
    modal.set_title(
        rf"(a) $m$ = {mode.azimuthal_number}, $q$ = {mode.phase / np.pi:.3g} $\pi$,"
        rf" $\alpha$ = {mode.growth_rate:.3g} $U/r_0$",
        loc="left",
        fontsize=10,
    )
    modal.set_xlabel(r"$\partial \alpha/\partial \log p$  ($U/r_0$)")
    modal.set_yticks(places, [entry.parameter.replace("_", " ") for entry in entries])
    base = result.base
    for offset, name, color, values in (
        (0.17, "cell velocity", GREEN, _logarithmic(result, "cell_velocity")),
        (-0.17, "effective viscosity", "#CC79A7", _logarithmic(result, "effective_viscosity")),
    ):
        steady.barh(places + offset, values, height=0.32, color=color, label=name)
    steady.set_xlabel(r"$\partial \log(\cdot)/\partial \log p$")
    steady.set_title(
        rf"(b) steady train: $U_c$ = {base.cell_velocity:.4g} $U$, $\mu_\mathrm{{eff}}$ ="
        rf" {base.effective_viscosity:.4g} $\mu$",
        loc="left",
        fontsize=10,
    )
    steady.legend(fontsize=9, frameon=False)
    for axes in (modal, steady):
        axes.axvline(0.0, color="0.3", linewidth=0.8)
        axes.tick_params(direction="in", top=True, right=True)
    figure.savefig(path)
    return path


def _logarithmic(result: ParameterSensitivities, quantity: str) -> list[float]:
    scale = getattr(result.base, quantity)
    return [
        entry.value * getattr(entry.base, quantity) / scale for entry in result.entries.values()
    ]
