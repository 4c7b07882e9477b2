"""Disturbances at first: simulations beside the linear theory, as in Figs. 4 and 9."""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from page import Page, plain_figure
from rich.console import Console

from celltrain import Run, Stability, Train, evolve, stability, steady
from celltrain.cli.progress import Reporter
from celltrain.evolution import Disturbance, Leading, Transient, linear_prediction
from celltrain.evolution.report import SimulationReporter

# r0/U: a fifth of the paper's pictures, by when nothing but the leading mode is left.
UNTIL = 50.0
# The paper: v_eta is below v_alpha of the same size from here on (Fig. 4), r0/U.
PAPER_CROSSING = 2.0
TRAIN = Train(diameter=10, packing=0.2, cells=8)


@dataclass(frozen=True)
class Panel:
    """One of the paper's pictures: which, the train, and the size of both disturbances."""

    figure: str
    train: Train
    amplitude: float


PANELS = (
    Panel("Fig. 4", TRAIN.changed(cells=2, viscosity_ratio=5.0), 1e-3),
    Panel("Fig. 9 (a)", TRAIN, 0.1),
    Panel("Fig. 9 (b)", TRAIN.changed(packing=0.7), 0.1),
)
COLORS = {"v_eta": "#D55E00", "v_alpha": "#0072B2"}


def simulated(start: Stability, disturbance: Disturbance) -> Run:
    """The disturbance in time."""
    with SimulationReporter(Console(stderr=True), quiet=False) as progress:
        return evolve(start, disturbance, until=UNTIL, every=UNTIL, progress=progress.step)


def study() -> None:
    page = Page("transients", "Disturbances at first")
    page.text(
        f"""
Simulations of v_alpha, the fastest mode, and v_eta, which grows fastest at first, each of the same
size eps (Eq. 8), beside the linear theory, |exp(A t) v|, until t = {UNTIL:g} r0/U. M = 12; times in
r0/U, those that the paper prints are a tenth of these.
"""
    )
    rows = []
    figure = plain_figure(10.0, 3.6)
    for panel, axes in zip(PANELS, figure.subplots(1, len(PANELS)), strict=True):
        with Reporter(Console(stderr=True), quiet=False) as reporter:
            base = steady(panel.train, progress=reporter.iteration)
            start = stability(base, estimate_error=False, progress=reporter.share)
        runs = {
            "v_eta": simulated(start, Transient(panel.amplitude)),
            "v_alpha": simulated(start, Leading(panel.amplitude)),
        }
        draw(axes, panel, start, runs)
        rows.append(row(panel, start, runs))
        page.log(" | ".join(rows[-1]))
    page.table(
        (
            "figure",
            "N, packing, viscosity ratio, eps",
            "largest eps of v_eta, over the first",
            "at t; cells went, D",
            "back at the first size after, D",
            "v_eta below v_alpha from t on (linear theory)",
            "from the linear theory at most, v_eta; v_alpha",
            "v_alpha from exp(alpha t) at most",
        ),
        rows,
    )
    page.text(
        f"""
The paper: v_eta follows exp(A t) and is below v_alpha from t = {PAPER_CROSSING:g} on (Fig. 4); it
grows about tenfold until the cells have gone 0.4 D, and is below its first size again within one D
(Sec. V B 2); at eps = 0.1 it does not lead to other growth (Fig. 9). Distances from the linear
theory are relative to it, the largest of all steps.
"""
    )
    page.figure(figure, "Simulations (points) and linear theory (lines)")
    page.write()


def row(panel: Panel, start: Stability, runs: dict[str, Run]) -> list[str]:
    """The numbers of one picture."""
    train, velocity = panel.train, start.base.cell_velocity
    history = runs["v_eta"].history
    size = history["eps"] / history["eps"][0]
    peak = int(np.argmax(size))
    back = peak + int(np.argmax(size[peak:] < 1.0)) if (size[peak:] < 1.0).any() else None
    went = velocity * history["time"] / train.tube.diameter
    crossings = [
        crossing(*(each.history["time"] for each in runs.values()), *sizes)
        for sizes in (
            [each.history["eps"] for each in runs.values()],
            [each.history["eps_linear"] for each in runs.values()],
        )
    ]
    off = [np.abs(each.history["eps"] / each.history["eps_linear"] - 1.0) for each in runs.values()]
    mode = runs["v_alpha"].history
    exponential = np.abs(mode["eps"] / mode["eps_exponential"] - 1.0)
    return [
        panel.figure,
        f"{train.cells}, {train.packing:g}, {train.flow.viscosity_ratio:g}, {panel.amplitude:g}",
        f"{size[peak]:.2f}",
        f"{history['time'][peak]:.2f}; {went[peak]:.2f}",
        f"not by t = {UNTIL:g}" if back is None else f"{went[back]:.2f}",
        f"{crossings[0]} ({crossings[1]})",
        "; ".join(f"{each.max():.1%}" for each in off),
        f"{exponential.max():.1%}",
    ]


def crossing(
    times: np.ndarray, other_times: np.ndarray, size: np.ndarray, other: np.ndarray
) -> str:
    """From when on a size stays below another, in words."""
    above = size > np.interp(times, other_times, other)
    if above[-1]:
        return "not yet"
    return f"{times[int(np.flatnonzero(above)[-1]) + 1]:.1f}"


def draw(axes: Axes, panel: Panel, start: Stability, runs: dict[str, Run]) -> None:
    """eps(t) in logarithmic axes, as the paper has it."""
    times = np.concatenate([[0.0], np.geomspace(1e-2, UNTIL, 120)])
    for name, run in runs.items():
        history = run.history
        begin = linear_prediction(start, run.disturbances[0])
        axes.loglog(times[1:], begin.sizes(times)[0][1:], color=COLORS[name], linewidth=1.0)
        axes.loglog(
            history["time"][1:],
            history["eps"][1:],
            ".",
            color=COLORS[name],
            label=name,
            markersize=4,
        )
    axes.set_title(f"{panel.figure}: packing {panel.train.packing:g}", fontsize=9, loc="left")
    axes.set_xlabel("t, r0/U")
    axes.set_ylabel("eps, r0")
    axes.legend(frameon=False, fontsize=8)
