"""Disturbances at first: simulations beside the linear theory, as in Figs. 4 and 9."""

import argparse
import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from datetime import UTC, datetime

import numpy as np
from degrees import FINE, PAPER
from matplotlib.axes import Axes
from page import DOTS_PER_INCH, FOLDER, Page, plain_figure

from celltrain import Run, Stability, Train, evolve, stability
from celltrain.cli.progress import Reporter
from celltrain.evolution import Disturbance, FastestAtFirst, Leading, linear_prediction
from celltrain.paper.initial import kept_volume
from celltrain.stability import PaperNorm, normed_blocks, propagator_norm

# r0/U: a fifth of the paper's pictures, by when nothing but the leading mode is left.
UNTIL = 50.0
FILE = FOLDER / "data" / "transients.json"
# Times of the linear theory, and until when the first maximum of v_eta is sought, r0/U.
TIMES = np.linspace(0.0, UNTIL, 5001)
SHORT = 10.0
# The paper's tenfold growth is reached when the cells have gone so many diameters.
EARLY = 0.4
# The paper: v_eta is below v_alpha of the same size from here on (Fig. 4), r0/U.
PAPER_CROSSING = 2.0
# How far (relative) what follows the linear theory may be from it.
CLOSE = 0.05
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


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of this study."""
    group = parser.add_argument_group("transients")
    group.add_argument(
        "--march",
        action="store_true",
        help="run the simulations of the study transients anew, which takes half an hour",
    )


def simulated(start: Stability, disturbance: Disturbance) -> Run:
    """The disturbance in time."""
    with Reporter() as progress:
        return evolve(start, disturbance, until=UNTIL, every=UNTIL, progress=progress.step)


def analysed(train: Train, degree: int) -> Stability:
    """The linear dynamics of a train at a degree."""
    return stability(train.changed(degree=degree), estimate_error=False)


def study(march: bool = False) -> None:
    page = Page("transients", "Disturbances at first")
    page.text(
        f"""
Simulations of v_alpha, the fastest mode, and v_eta, which grows fastest at first, each of the same
size eps (Eq. 8), beside the linear theory, |exp(A t) v|, until t = {UNTIL:g} r0/U, at the paper's
resolution, M = {PAPER}; then what the linear theory says at M = {FINE}. Times in r0/U, those that
the paper prints are a tenth of these.
"""
    )
    starts = {panel.figure: analysed(panel.train, PAPER) for panel in PANELS}
    page.log("linear dynamics")
    if march:
        simulate(page, starts)
    day, found = kept()
    page.heading(f"Simulations, M = {PAPER}")
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
        f"""
Distances from the linear theory are relative to it, the largest of all steps. The simulations were
run on {day}; their numbers are kept in `data/{FILE.name}`, and `--march` runs them, and draws the
picture, anew.
"""
    )
    caption = "Simulations (points) and linear theory (lines)"
    page.parts.append(f"![{caption}]({page.name}.png)\n\n*{caption}, M = {PAPER}*")
    linear = converged_part(page, starts)
    page.heading("Beside the paper's statements")
    page.table(("the paper says", "found", "holds"), statements(found, linear))
    page.write()


@dataclass(frozen=True)
class Measures:
    """What is found for one picture; times in r0/U, ways of the cells in diameters of the tube.

    `growth`: largest eps of v_eta over its first, reached at `peak`, after `peak_way`; `back_way`:
    when it is at its first size again; `crossing` and `linear_crossing`: from when on v_eta is
    below v_alpha, in the simulation and in the linear theory; nan for what does not happen. `off`:
    largest distances from the linear theory, of v_eta and of v_alpha, and of the latter from
    exp(alpha t).
    """

    growth: float
    peak: float
    peak_way: float
    back_way: float
    crossing: float
    linear_crossing: float
    off: tuple[float, float, float]


def simulate(page: Page, starts: dict[str, Stability]) -> None:
    """Run all simulations, keep their numbers, and draw them."""
    figure = plain_figure(10.0, 3.6)
    found = {}
    for panel, axes in zip(PANELS, figure.subplots(1, len(PANELS)), strict=True):
        start = starts[panel.figure]
        runs = {
            "v_eta": simulated(start, FastestAtFirst(panel.amplitude)),
            "v_alpha": simulated(start, Leading(panel.amplitude)),
        }
        draw(axes, panel, start, runs)
        found[panel.figure] = measure(start, runs)
        page.log(" | ".join(row(panel, found[panel.figure])))
    figure.savefig(FOLDER / f"{page.name}.png", dpi=DOTS_PER_INCH)
    day = datetime.now(UTC).strftime("%Y-%m-%d")
    panels = {name: asdict(each) for name, each in found.items()}
    kept_now = {"simulated": day, "degree": PAPER, "panels": panels}
    FILE.write_text(json.dumps(kept_now, indent=1) + "\n")


def kept() -> tuple[str, dict[str, Measures]]:
    """The day of the simulations, and their numbers."""
    content = json.loads(FILE.read_text())
    return content["simulated"], {
        name: Measures(**each) for name, each in content["panels"].items()
    }


def measure(start: Stability, runs: dict[str, Run]) -> Measures:
    """The numbers of one picture."""
    eta, alpha = (each.history for each in runs.values())
    size = eta["eps"] / eta["eps"][0]
    peak = int(np.argmax(size))
    smaller = np.flatnonzero(size[peak:] < 1.0)
    way = start.base.cell_velocity / start.base.train.tube.diameter
    return Measures(
        growth=float(size[peak]),
        peak=float(eta["time"][peak]),
        peak_way=way * float(eta["time"][peak]),
        back_way=way * float(eta["time"][peak + smaller[0]]) if smaller.size else float("nan"),
        crossing=crossing(eta, alpha, "eps"),
        linear_crossing=crossing(eta, alpha, "eps_linear"),
        off=(
            float(np.abs(eta["eps"] / eta["eps_linear"] - 1.0).max()),
            float(np.abs(alpha["eps"] / alpha["eps_linear"] - 1.0).max()),
            float(np.abs(alpha["eps"] / alpha["eps_exponential"] - 1.0).max()),
        ),
    )


@dataclass(frozen=True)
class Linear:
    """What the linear theory says of one picture at one degree, as in `Measures`.

    `early`: the largest growth that any disturbance can have (G of Eq. 8's norm) by the time at
    which the cells have gone `EARLY` diameters. `growth_of` maps a name to eps(t) over its first.
    """

    eta: float
    alpha: float
    growth: float
    peak: float
    peak_way: float
    back_way: float
    crossing: float
    early: float
    place: str
    growth_of: dict[str, np.ndarray]


def linear_measures(start: Stability) -> Linear:
    """The numbers of the linear theory."""
    sizes = {
        name: linear_prediction(start, kept_volume(start, disturbance.shapes(start))).sizes(TIMES)[
            0
        ]
        for name, disturbance in (("v_eta", FastestAtFirst(1e-3)), ("v_alpha", Leading(1e-3)))
    }
    sizes = {name: each / each[0] for name, each in sizes.items()}
    size = sizes["v_eta"]
    peak = int(np.argmax(size[TIMES < SHORT]))
    smaller = np.flatnonzero(size[peak:] < 1.0)
    way = start.base.cell_velocity / start.base.train.tube.diameter
    histories = [{"time": TIMES, "eps": each} for each in sizes.values()]
    early = max(
        float(propagator_norm(block.matrix, np.array([EARLY / way]))[0])
        for block in normed_blocks(start, PaperNorm()).values()
    )
    return Linear(
        eta=start.numerical_abscissa,
        alpha=start.spectral_abscissa,
        growth=float(size[peak]),
        peak=float(TIMES[peak]),
        peak_way=way * float(TIMES[peak]),
        back_way=way * float(TIMES[peak + smaller[0]]) if smaller.size else float("nan"),
        crossing=crossing(histories[0], histories[1], "eps"),
        early=early,
        place=f"{start.transient.azimuthal_number}, {start.transient.wave_number}",
        growth_of=sizes,
    )


def converged_part(page: Page, starts: dict[str, Stability]) -> dict[str, Linear]:
    """The linear theory at both degrees; returns that of the higher one."""
    page.heading(f"The linear theory at M = {FINE}")
    page.text(
        f"""
v_eta is not the same disturbance at another degree: eta needs a higher degree than alpha does (see
[convergence](convergence.md)), and a finer disturbance grows faster at first but gets no further.
Where v_eta changes the volumes of cells, as in Fig. 4, that part is left out, as it is in the
simulations. m, j: its azimuthal and wave number. G: the largest growth of any disturbance by the
time at which the cells have gone {EARLY:g} D, where the paper has a tenfold one.
"""
    )
    rows, found = [], {}
    figure = plain_figure(10.0, 3.6)
    for panel, axes in zip(PANELS, figure.subplots(1, len(PANELS)), strict=True):
        for degree, style in ((PAPER, "--"), (FINE, "-")):
            start = starts[panel.figure] if degree == PAPER else analysed(panel.train, degree)
            each = linear_measures(start)
            if degree == FINE:
                found[panel.figure] = each
            rows.append(
                (
                    panel.figure,
                    degree,
                    f"{each.alpha:.5f}",
                    f"{each.eta:.3f}",
                    each.place,
                    f"{each.growth:.2f}",
                    f"{each.peak:.2f}; {each.peak_way:.2f}",
                    f"{each.back_way:.2f}",
                    f"{each.crossing:.1f}",
                    f"{each.early:.2f}",
                )
            )
            for name, size in each.growth_of.items():
                axes.loglog(
                    TIMES[1:],
                    size[1:],
                    style,
                    color=COLORS[name],
                    linewidth=1.2,
                    label=f"{name}, M = {degree}",
                )
            page.log(f"{panel.figure}, degree {degree}")
        axes.set_title(f"{panel.figure}: packing {panel.train.packing:g}", fontsize=9, loc="left")
        axes.set_xlabel("t, r0/U")
        axes.set_yticks([0.3, 0.5, 1.0, 2.0], ["0.3", "0.5", "1", "2"])
        axes.minorticks_off()
        axes.set_ylim(0.25, 2.4)
    # Every panel has the same lines.
    left, *_ = figure.axes
    left.set_ylabel("eps over its first")
    left.legend(frameon=False, fontsize=8, loc="lower left")
    page.table(
        (
            "figure",
            "M",
            "alpha, U/r0",
            "eta, U/r0",
            "m, j",
            "largest eps of v_eta, over the first",
            "at t; cells went, D",
            "back at the first size after, D",
            "v_eta below v_alpha from t on",
            f"G at {EARLY:g} D",
        ),
        rows,
    )
    path = FOLDER / f"{page.name}-linear.png"
    figure.savefig(path, dpi=DOTS_PER_INCH)
    caption = f"The linear theory at M = {PAPER} (dashed) and {FINE} (full)"
    page.parts.append(f"![{caption}]({path.name})\n\n*{caption}*")
    return found


def crossing(one: dict[str, np.ndarray], other: dict[str, np.ndarray], size: str) -> float:
    """From when on one size stays below another; nan if it does not."""
    above = one[size] > np.interp(one["time"], other["time"], other[size])
    return float("nan") if above[-1] else float(one["time"][np.flatnonzero(above)[-1] + 1])


def row(panel: Panel, found: Measures) -> list[str]:
    """A line of the table."""
    train = panel.train
    return [
        panel.figure,
        f"{train.cells}, {train.packing:g}, {train.flow.viscosity_ratio:g}, {panel.amplitude:g}",
        f"{found.growth:.2f}",
        f"{found.peak:.2f}; {found.peak_way:.2f}",
        f"{found.back_way:.2f}",
        f"{found.crossing:.1f} ({found.linear_crossing:.1f})",
        f"{found.off[0]:.1%}; {found.off[1]:.1%}",
        f"{found.off[2]:.1%}",
    ]


def statements(found: dict[str, Measures], linear: dict[str, Linear]) -> list[tuple[str, str, str]]:
    """The paper's statements, what was found, and whether they hold."""
    first = PANELS[0].figure
    small, all_of, fine = found[first], list(found.values()), list(linear.values())
    large = [each for name, each in found.items() if name != first]
    ways = [[each.back_way for each in those] for those in (all_of, fine)]
    followed = max(each.off[0] for each in large)
    crossings = (small.crossing, linear[first].crossing)
    growths = [[each.growth for each in those] for those in (all_of, fine)]

    def both(coarse: Iterable[str], better: Iterable[str], unit: str = "") -> str:
        return f"{', '.join(coarse)}{unit}; M = {FINE}: {', '.join(better)}{unit}"

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
            f"from {small.crossing:.1f} on; M = {FINE}: from {linear[first].crossing:.1f} on",
            answers(0.5 < each / PAPER_CROSSING < 2.0 for each in crossings),
        ),
        (
            "Sec. V B 2: v_eta grows about tenfold (here: five- to twentyfold)",
            both(
                (f"{each.growth:.2f}" for each in all_of), (f"{each.growth:.2f}" for each in fine)
            ),
            answers(all(5.0 < each < 20.0 for each in those) for those in growths),
        ),
        (
            "Sec. V B 2: and is below its first size again when the cells have gone one D",
            both(
                (f"{each.back_way:.2f}" for each in all_of),
                (f"{each.back_way:.2f}" for each in fine),
                " D",
            ),
            answers(all(each < 1.0 for each in those) for those in ways),
        ),
        (
            f"Fig. 9: eps = 0.1 in v_eta leads to no other growth (here: within {CLOSE:.0%})",
            f"within {followed:.1%} of the linear theory",
            answer(followed < CLOSE),
        ),
    ]


def answers(hold: Iterable[bool]) -> str:
    """At the paper's degree and at the higher one."""
    paper, fine = (answer(each) for each in hold)
    return f"{paper}; M = {FINE}: {fine}"


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
