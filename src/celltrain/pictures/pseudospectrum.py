"""Pseudospectra as level lines in the complex plane."""

import numpy as np
from matplotlib.figure import Figure

from celltrain.pictures.style import ORANGE, PURPLE, VERMILION, color_bar, in_style
from celltrain.stability import Pseudospectrum


@in_style()
def draw_pseudospectrum(result: Pseudospectrum) -> Figure:
    """Lines of equal |(z - B)^-1|, the eigenvalues, and the spectral and numerical abscissas.

    The star is where the Kreiss constant is found, if that is within the picture.
    """
    figure = Figure(figsize=(6.4, 5.2), layout="constrained")
    axes = figure.add_subplot()
    levels = np.log10(np.maximum(result.smallest, 1e-300))
    lowest = max(float(np.floor(levels.min() * 4) / 4), -4.0)
    highest = float(np.ceil(levels.max() * 4) / 4)
    drawn = axes.contourf(
        result.real,
        result.imaginary,
        levels,
        levels=np.arange(lowest, highest + 0.125, 0.25).tolist(),
        cmap="viridis_r",
        extend="min",
    )
    axes.contour(
        result.real, result.imaginary, levels, levels=drawn.levels, colors="white", linewidths=0.3
    )
    color_bar(axes, drawn, r"$\log_{10} \epsilon$,  $|(z - B)^{-1}| = 1/\epsilon$")
    values = result.eigenvalues
    axes.plot(values.real, values.imag, "o", markersize=3.5, color="black", markeredgecolor="white")
    axes.axvline(0.0, color="black", linewidth=0.8)
    for rate, name, color in (
        (result.spectral_abscissa, r"$\alpha$", VERMILION),
        (result.numerical_abscissa, r"$\eta$", PURPLE),
    ):
        axes.axvline(
            rate, color=color, linewidth=1.2, linestyle=(0, (4, 3)), label=f"{name} = {rate:.3g}"
        )
    point = result.kreiss.point
    if np.isfinite(point):
        axes.plot(point.real, point.imag, "*", markersize=11, color=ORANGE, markeredgecolor="k")
    axes.set_xlim(result.real[0], result.real[-1])
    axes.set_ylim(result.imaginary[0], result.imaginary[-1])
    axes.set_xlabel(r"Re $z$  ($U/r_0$)")
    axes.set_ylabel(r"Im $z$  ($U/r_0$)")
    axes.set_title(
        f"$m$ = {result.azimuthal_number}, $j$ = {result.wave_number}, norm {result.norm}:"
        f" Kreiss constant {result.kreiss.constant:.3g}",
    )
    axes.legend(loc="upper left", frameon=True)
    return figure
