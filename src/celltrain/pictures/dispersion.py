"""Growth rates of an infinite train over the phase from cell to cell."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from celltrain.pictures.spectrum import number_color
from celltrain.pictures.style import ORANGE, in_style
from celltrain.stability import InfiniteTrain


@in_style()
def draw_dispersion(result: InfiniteTrain) -> Figure:
    """alpha_m(q) and eta_m(q) for each azimuthal number m, with the most unstable wave marked.

    The growth rates' axis is linear close to 0 and logarithmic further away, as modes of different
    m decay at very different rates. For m = 0 the curves end before q = 0, where the displacement
    of the train is set aside; the hollow points are what remains.
    """
    figure = Figure(figsize=(10.0, 4.4), layout="constrained")
    modal, abrupt = figure.subplots(1, 2)
    phases = result.phases / np.pi
    best = result.most_unstable
    for m in result.azimuthal_numbers:
        color = number_color(m)
        for axes, values in (
            (modal, result.growth_rates(m)),
            (abrupt, result.numerical_abscissas[m]),
        ):
            apart = m == 0 and phases[0] == 0.0
            first = 1 if apart else 0
            axes.plot(
                phases[first:],
                values[first:],
                color=color,
                marker="o",
                markersize=3.0,
                linewidth=1.3,
                label=f"$m$ = {m}",
            )
            if apart:
                axes.plot(
                    phases[0], values[0], "o", markersize=5, color=color, markerfacecolor="none"
                )
    modal.axhline(0.0, color="0.3", linewidth=0.8, zorder=1)
    modal.plot(
        best.phase / np.pi,
        best.growth_rate,
        marker="*",
        markersize=13,
        color="none",
        markerfacecolor=ORANGE,
        markeredgecolor="0.2",
        label="most unstable",
        zorder=5,
    )
    modal.set_yscale("symlog", linthresh=max(2.0 * abs(best.growth_rate), 1e-3))
    modal.set_ylabel(r"growth rate  $\alpha_m(q)$  ($U/r_0$)")
    modal.set_title(
        rf"(a) $\alpha$ = {best.growth_rate:.3g} $U/r_0$ at $q$ = {best.phase / np.pi:.3g}"
        rf" $\pi$, $m$ = {best.azimuthal_number}",
    )
    abrupt.set_ylabel(r"initial growth rate  $\eta_m(q)$  ($U/r_0$)")
    abrupt.set_title(f"(b) norm: {result.norm}")
    for axes in (modal, abrupt):
        _finish(axes)
    modal.legend()
    return figure


def _finish(axes: Axes) -> None:
    axes.set_xlabel(r"phase from cell to cell  $q/\pi$")
    axes.set_xlim(-0.02, 1.02)
