"""Growth of eps_x of the leading mode and of displaced cells: Fig. 11 by the linear theory."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from celltrain.evolution import Leading, RandomDisplacement, linear_prediction
from celltrain.paper.curves import side_by_side
from celltrain.paper.finding import Finding, finding
from celltrain.paper.resolutions import LABELS, PAPER, Resolutions, Style, present
from celltrain.paper.trains import CELLS, analysed, dataset
from celltrain.parameters import paper_units

PACKINGS = (0.2, 0.7)
#: How many times longer the paper's ad hoc disturbance takes to eps_x = 1, and what that may mean.
SLOWER, LEEWAY = {0.2: 4.3, 0.7: 2.7}, 0.3
AMPLITUDE, SEEDS = 0.1, range(20)
#: r0/U.
TIMES = np.arange(0.0, 4000.0, 10.0)


def compute(degree: int | None) -> xr.Dataset:
    """eps_x of the leading mode and of 20 ad hoc disturbances, eps = 0.1 at first, D = 10."""
    modes = np.full((len(PACKINGS), len(TIMES)), np.nan)
    random = np.full((len(PACKINGS), len(SEEDS), len(TIMES)), np.nan)
    for row, packing in enumerate(PACKINGS):
        start = analysed(degree, numbers=(0, 1), cells=CELLS, diameter=10.0, packing=packing)
        shapes = [Leading(AMPLITUDE).shapes(start)]
        shapes += [RandomDisplacement(AMPLITUDE, seed).shapes(start) for seed in SEEDS]
        modes[row], *found = (linear_prediction(start, each).sizes(TIMES)[1] for each in shapes)
        random[row] = found
    return dataset(
        {
            "mode": (("packing", "time"), modes, "r0", "eps_x of the leading mode"),
            "random": (("packing", "seed", "time"), random, "r0", "eps_x of displaced cells"),
        },
        {
            "packing": list(PACKINGS),
            "seed": list(SEEDS),
            "time": ("time", TIMES, {"units": "r0/U"}),
        },
        "eps_x by the linear theory, D = 10, N = 8",
    )


def draw(data: Resolutions) -> Figure:
    """Fig. 11 by the linear theory: the mode, and the range of the ad hoc disturbances."""
    figure, panels = side_by_side(2)
    for axes, packing in zip(panels, PACKINGS, strict=True):
        for name, each in present(data):
            at = each.sel(packing=packing)
            time = paper_units.time(at["time"].values)
            every = slice(None, None, 20) if name == PAPER else slice(None)
            style: Style = {"marker": "o", "mfc": "none", "ls": "none"} if name == PAPER else {}
            words = LABELS[name]
            mode, median = at["mode"].values, at["random"].median("seed").values
            axes.plot(time[every], mode[every], color="C0", ms=4, label=f"mode, {words}", **style)
            axes.plot(
                time[every],
                median[every],
                color="C1",
                ms=4,
                label=f"displaced cells, {words}",
                **style,
            )
            if name != PAPER:
                low, high = at["random"].min("seed").values, at["random"].max("seed").values
                axes.fill_between(time, low, high, color="C1", alpha=0.2, linewidth=0)
        axes.axhline(1.0, color="0.6", linewidth=0.8, zorder=0)
        last = 60.0 if packing < 0.5 else 150.0
        axes.set(yscale="log", xlim=(0.0, last), ylim=(1e-2, 1e2))
        axes.set(xlabel=r"$t\, U^*/r_0$", ylabel=r"$\varepsilon_x/r_0$")
        axes.set_title(f"{axes.get_title()}  $\\phi$ = {packing:g}", fontsize=10)
    panels[0].legend(fontsize=7, frameon=False)
    return figure


def findings(data: xr.Dataset) -> list[Finding]:
    """What the linear theory says of the ad hoc disturbance (Fig. 11)."""
    found = []
    for packing, slower in SLOWER.items():
        at = data.sel(packing=packing)
        mode = _reached(at["mode"].values)
        factors = np.array([_reached(each) for each in at["random"].values]) / mode
        median = float(np.median(factors))
        found.append(
            finding(
                "P16",
                f"packing {packing:g}: displaced cells take {slower:g} times as long as the mode to"
                " eps_x = 1 (linear theory)",
                f"{median:.2f} in the median of {factors.size}, {factors.min():.2f} to"
                f" {factors.max():.2f}",
                abs(median / slower - 1.0) < LEEWAY,
                [mode, median],
            )
        )
    return found


def _reached(sizes: np.ndarray) -> float:
    """When a size first reaches 1, r0/U; infinite if it does not within the times."""
    above = np.flatnonzero(sizes > 1.0)
    if not above.size:
        return float("inf")
    last = int(above[0])
    if last == 0:
        return 0.0
    return float(np.interp(0.0, np.log(sizes[last - 1 : last + 1]), TIMES[last - 1 : last + 1]))
