"""What the leading mode and the disturbance that grows fastest at first do to the cells."""

import numpy as np
from matplotlib.figure import Figure

from celltrain.diagnostics import Mechanisms
from celltrain.pictures.style import COLORS, in_style

LABELS = {
    "leading mode": r"$v_\alpha$, leading mode",
    "fastest at first": r"$v_\eta$, fastest at first",
}


@in_style()
def draw_strain_energies(found: Mechanisms) -> Figure:
    """Strain energy of both disturbances by shear, dilatation and bending (Eq. 24, Table I)."""
    figure = Figure(figsize=(6.0, 3.8), layout="constrained")
    axes = figure.add_subplot()
    parts = tuple(found.strains[0].energies)
    places = np.arange(len(parts) + 1)
    largest = 0.0
    for offset, each, color in zip((-0.2, 0.2), found.strains, COLORS, strict=False):
        values = np.array(list(each.energies.values()))
        heights = np.append(values, values.sum())
        largest = max(largest, float(np.abs(values).max()))
        axes.bar(places + offset, heights, width=0.38, color=color, label=LABELS[each.name])
    axes.set_yscale("symlog", linthresh=1e-3 * largest)
    axes.axhline(0.0, color="0.3", linewidth=0.8)
    axes.set_xticks(places, [*parts, "sum"])
    axes.tick_params(top=False)
    axes.set_ylabel(r"$W$ of a disturbance ($\mu U r_0^2$)")
    axes.legend()
    return figure


@in_style()
def draw_deformation_spectra(found: Mechanisms) -> Figure:
    """Share of each degree n in both disturbances (E_n of Eq. 16, Fig. 10)."""
    figure = Figure(figsize=(5.6, 3.8), layout="constrained")
    axes = figure.add_subplot()
    for each, color in zip(found.strains, COLORS, strict=False):
        share = each.spectrum / each.spectrum.sum()
        axes.semilogy(share, "o-", color=color, markersize=4, label=LABELS[each.name])
    axes.set_xlabel("degree $n$")
    axes.set_ylabel(r"$E_n/\sum_n E_n$")
    axes.legend()
    return figure


@in_style()
def draw_mode_motions(found: Mechanisms) -> Figure:
    """Tumbling and tank-treading of the leading modes (Eqs. 17 to 21)."""
    figure = Figure(figsize=(2.4 + 0.8 * len(found.modes), 3.8), layout="constrained")
    axes = figure.add_subplot()
    places = np.arange(len(found.modes))
    parts = (
        (r"tumbling $|\omega|$", [each.tumbling for each in found.modes]),
        (r"tank-treading $|\Omega - \omega|$", [each.tank_treading for each in found.modes]),
    )
    for offset, (name, values), color in zip((-0.2, 0.2), parts, COLORS, strict=False):
        axes.bar(places + offset, values, width=0.38, color=color, label=name)
    names = [
        f"$m$ = {mode.azimuthal_number}\n$j$ = {mode.wave_number}\n{mode.growth_rate:.2g}"
        for mode in found.modes
    ]
    axes.set_xticks(places, names, fontsize=8)
    axes.tick_params(top=False)
    axes.set_xlabel("mode and growth rate ($U/r_0$)")
    axes.set_ylabel("rotation over amplitude ($U/r_0^2$)")
    axes.legend()
    return figure
