"""Growth rates with their error bars."""

import numpy as np
from matplotlib.figure import Figure

from celltrain.parameters import CaseError
from celltrain.pictures.style import BLUE, SKY, in_style
from celltrain.stability import Stability


@in_style()
def draw_error_bars(result: Stability) -> Figure:
    """Leading growth rates, each with its bar: by the degree (thick) and with the rules (thin).

    Raises:
        CaseError: for a result without error bars.
    """
    bars = result.error_bars
    if not bars:
        raise CaseError("a result without error bars is not allowed: see with_error_bars")
    figure = Figure(figsize=(2.4 + 0.7 * len(bars), 3.8), layout="constrained")
    axes = figure.add_subplot()
    places = np.arange(len(bars))
    rates = [bar.mode.growth_rate for bar in bars]
    for sizes, width, color in (
        ([bar.total for bar in bars], 1.2, "0.3"),
        ([bar.by_degree for bar in bars], 4.0, SKY),
    ):
        axes.errorbar(places, rates, yerr=sizes, fmt="none", ecolor=color, elinewidth=width)
    axes.plot(places, rates, "o", color=BLUE, zorder=3)
    axes.axhline(0.0, color="0.3", linewidth=0.8)
    names = [f"$m$ = {bar.mode.azimuthal_number}\n$j$ = {bar.mode.wave_number}" for bar in bars]
    axes.set_xticks(places, names, fontsize=8)
    axes.set_ylabel(r"growth rate ($U/r_0$)")
    known = {1: "positive", -1: "negative", 0: "left open", None: "left open"}
    axes.set_title(f"sign of the largest: {known[result.growth_sign]}")
    axes.tick_params(top=False)
    return figure
