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
# How far (relative) what follows the linear theory may be from it.
CLOSE = 0.05
TRAIN = Train(diameter=10, packing=0.2, cells=8, degree=12)


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
    found: dict[str, Measures] = {}
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
        found[panel.figure] = measure(start, runs)
        page.log(" | ".join(row(panel, found[panel.figure])))
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
        [row(panel, found[panel.figure]) for panel in PANELS],
    )
    page.text(
        """
Distances from the linear theory are relative to it, the largest of all steps.
"""
    )
    page.heading("Beside the paper's statements")
    page.table(("the paper says", "found", "holds"), statements(found))
    page.figure(figure, "Simulations (points) and linear theory (lines)")
    page.write()


@dataclass(frozen=True)
class Measures:
    """What is found for one picture; times in r0/U, ways of the cells in diameters.

    `growth`: largest eps of v_eta over its first, reached at `peak`; `back`: when it is at its
    first size again; `crossing` and `linear_crossing`: from when on v_eta is below v_alpha, in the
    simulation and in the linear theory; nan for what does not happen. `off`: largest distances
    from the linear theory, of v_eta and of v_alpha, and of the latter from exp(alpha t).
    """

    growth: float
    peak: float
    back: float
    diameters_per_time: float
    crossing: float
    linear_crossing: float
    off: tuple[float, float, float]


def measure(start: Stability, runs: dict[str, Run]) -> Measures:
    """The numbers of one picture."""
    eta, alpha = (each.history for each in runs.values())
    size = eta["eps"] / eta["eps"][0]
    peak = int(np.argmax(size))
    smaller = np.flatnonzero(size[peak:] < 1.0)
    return Measures(
        growth=float(size[peak]),
        peak=float(eta["time"][peak]),
        back=float(eta["time"][peak + smaller[0]]) if smaller.size else float("nan"),
        diameters_per_time=start.base.cell_velocity / start.base.train.tube.diameter,
        crossing=crossing(eta, alpha, "eps"),
        linear_crossing=crossing(eta, alpha, "eps_linear"),
        off=(
            float(np.abs(eta["eps"] / eta["eps_linear"] - 1.0).max()),
            float(np.abs(alpha["eps"] / alpha["eps_linear"] - 1.0).max()),
            float(np.abs(alpha["eps"] / alpha["eps_exponential"] - 1.0).max()),
        ),
    )


def crossing(one: dict[str, np.ndarray], other: dict[str, np.ndarray], size: str) -> float:
    """From when on one size stays below another; nan if it does not."""
    above = one[size] > np.interp(one["time"], other["time"], other[size])
    return float("nan") if above[-1] else float(one["time"][np.flatnonzero(above)[-1] + 1])


def row(panel: Panel, found: Measures) -> list[str]:
    """A line of the table."""
    train, way = panel.train, found.diameters_per_time
    return [
        panel.figure,
        f"{train.cells}, {train.packing:g}, {train.flow.viscosity_ratio:g}, {panel.amplitude:g}",
        f"{found.growth:.2f}",
        f"{found.peak:.2f}; {found.peak * way:.2f}",
        f"{found.back * way:.2f}",
        f"{found.crossing:.1f} ({found.linear_crossing:.1f})",
        f"{found.off[0]:.1%}; {found.off[1]:.1%}",
        f"{found.off[2]:.1%}",
    ]


def statements(found: dict[str, Measures]) -> list[tuple[str, str, str]]:
    """The paper's statements, what was found, and whether they hold."""
    small, all_of = found[PANELS[0].figure], list(found.values())
    large = [each for name, each in found.items() if name != PANELS[0].figure]
    ways = [each.back * each.diameters_per_time for each in all_of]
    followed = max(each.off[0] for each in large)
    return [
        (
            f"Fig. 4: v_eta follows exp(A t) (here: within {CLOSE:.0%})",
            f"within {small.off[0]:.1%}",
            answer(small.off[0] < CLOSE),
        ),
        (
            f"Fig. 4: v_alpha follows exp(alpha t) (here: within {CLOSE:.0%})",
            f"within {small.off[2]:.1%}",
            answer(small.off[2] < CLOSE),
        ),
        (
            f"Fig. 4: v_eta is below v_alpha from t = {PAPER_CROSSING:g} on (within a factor of"
            " two)",
            f"from {small.crossing:.1f} on",
            answer(0.5 < small.crossing / PAPER_CROSSING < 2.0),
        ),
        (
            "Sec. V B 2: v_eta grows about tenfold (here: five- to twentyfold)",
            ", ".join(f"{each.growth:.2f}" for each in all_of),
            answer(all(5.0 < each.growth < 20.0 for each in all_of)),
        ),
        (
            "Sec. V B 2: and is below its first size again when the cells have gone one D",
            ", ".join(f"{each:.2f} D" for each in ways),
            answer(all(each < 1.0 for each in ways)),
        ),
        (
            f"Fig. 9: eps = 0.1 in v_eta leads to no other growth (here: within {CLOSE:.0%})",
            f"within {followed:.1%} of the linear theory",
            answer(followed < CLOSE),
        ),
    ]


def answer(holds: bool) -> str:
    return "yes" if holds else "no"


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
