"""From a small disturbance to disorder: the breakup of a dense train (Figs. 1, 11 and 12).

Its simulations take hours each, so they are only begun, or gone on with, when asked for by name;
the page is made from what there is of them, finished or not.
"""

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from breakup_ends import FILMS, ends_section, keep_states, simulate_films
from breakup_linear import PAPER_SLOWER, ad_hoc_section
from breakup_runs import AMPLITUDE, CASES, CLOSE, DENSE, PAPER_TIMES, at, simulate, summarise
from page import FOLDER, Page, plain_figure

RUNS = Path("out/breakup")
COLORS = {
    "leading": "#0072B2",
    "random": "#D55E00",
    "sparse": "#E69F00",
    "eight": "#009E73",
    "twelve": "#CC79A7",
}
# What the paper says of its t U/r0 = 0, 61, 72, 97, 108 and 141.
PAPER_SAYS = (
    "the train, slightly disturbed",
    "neighbours tilt, displaced, and turn oppositely",
    "slipper-like shapes, alternating",
    "the structure of two cells separates",
    "breaks up (picture)",
    "disordered (last picture)",
)
# The paper: the size up to which the mode grows as linear theory says.
PAPER_LINEAR = {"leading": 0.5, "sparse": 5.0}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of this study."""
    names = ", ".join((*CASES, *FILMS))
    group = parser.add_argument_group("breakup")
    group.add_argument(
        "--simulate",
        nargs="+",
        default=[],
        choices=[*CASES, *FILMS],
        help=f"simulations to run, or to go on with, first; each takes hours ({names})",
    )
    group.add_argument(
        "--take",
        nargs="+",
        default=[],
        type=_taken,
        metavar="NAME=FILE",
        help="files of simulations that are elsewhere, read only",
    )
    group.add_argument(
        "--runs", type=Path, default=RUNS, help=f"folder of the simulations (default: {RUNS})"
    )


def _taken(text: str) -> tuple[str, Path]:
    name, _, path = text.partition("=")
    if name not in CASES or not Path(path).is_file():
        raise argparse.ArgumentTypeError(
            f"{text!r} is not allowed; allowed: NAME=FILE with a file that is there and a NAME of"
            f" {', '.join(CASES)}"
        )
    return name, Path(path)


def study(
    folder: Path = RUNS,
    wanted: Sequence[str] = (),
    elsewhere: Mapping[str, Path] | None = None,
) -> None:
    for name in wanted:
        path = folder / f"{name}.nc"
        if name in CASES:
            simulate(name, path)
        else:
            simulate_films(name, path)
        if name == "leading":
            # From what is kept of it the others begin.
            keep_states(path)
    page = Page("breakup", "Breakup of a train")
    page.text(
        """
A train of cells in a tube of diameter 10 r0, default resolution (M = 12), viscosity
ratio 1, from a small disturbance on. eps and eps_x as in the paper (Eq. 8 and Fig. 11), but eps_x
here is the root of the sum over the cells. Times in r0/U; those that the paper prints are a tenth
of these. The simulations take hours; `python validation/run.py breakup --simulate NAME` runs one of
them, or goes on with it, and makes this page anew from what there is. A number holds here if it is
within a factor of two of the paper's.
"""
    )
    places = {name: folder / f"{name}.nc" for name in CASES} | dict(elsewhere or {})
    found: dict[str, dict[str, Any]] = {}
    for name, path in places.items():
        if content := summarise(name, path):
            found[name] = content
            page.log(f"{name}: {state(name, content)}")
    runs_table(page, found)
    page.heading("Beside the paper's statements")
    page.table(("the paper says", "found", "holds"), statements(found))
    if "leading" in found:
        course(page, found["leading"])
    ends_section(page, folder)
    ad_hoc_section(page, DENSE, AMPLITUDE)
    figure(page, found)
    pictures(page, found)
    page.write()


def state(name: str, content: Mapping[str, Any] | None) -> str:
    """How far a simulation is, in words."""
    if not content:
        return "not run"
    if finished(name, content):
        return f"finished at {content['time']:.0f}"
    ending = content["ending"]
    reason = "" if ending["kind"] == "running" else f" ({ending['message']})"
    return f"not finished: {content['time']:.0f} of {CASES[name].until:.0f}{reason}"


def finished(name: str, content: Mapping[str, Any]) -> bool:
    """Whether a simulation has been followed as long as it is meant to be."""
    return bool(content["times"][-1] >= CASES[name].until * (1.0 - 1e-9))


def runs_table(page: Page, found: Mapping[str, Mapping[str, Any]]) -> None:
    """All simulations, run or not."""
    rows = []
    for name, case in CASES.items():
        content = found.get(name)
        row = [
            name,
            case.shows,
            f"{case.train.cells}, {case.train.packing:.3g}",
            str(case.disturbance),
            state(name, content),
        ]
        if content is not None:
            hours = content["wall_seconds"] / 3600.0
            row += [
                f"{hours:.1f}",
                content["evaluations"],
                f"{content['time'] / hours:.0f}",
                f"{content['largest_volume_correction']:.1e}",
                repulsion(content),
            ]
        else:
            row += [""] * 5
        rows.append(row)
    page.heading("Simulations")
    columns = ("name", "what", "N, packing", "disturbance", "state, r0/U", "hours")
    page.table(
        (
            *columns,
            "evaluations",
            "r0/U per hour",
            "largest correction of a volume, r0",
            "repulsion",
        ),
        rows,
    )
    page.text(
        """
Repulsion: what keeps membranes apart in films that the harmonics do not resolve, see [the
method](../method.md). Since when it acted, the thinnest film, the largest force of films on a cell,
and the largest energy of all films over that of the membranes; before that it is absent.
"""
    )


def repulsion(content: Mapping[str, Any]) -> str:
    """How much the repulsion acted, in words."""
    record = content["repulsion"]
    if record["since"] is None:
        return f"none within {record['range']:g} r0"
    parts = (
        f"since {record['since']:.0f}",
        f"{record['smallest_gap']:.4f} r0",
        f"{record['largest_force']:.2g} mu U r0",
        f"{record['largest_energy_share']:.1e}",
    )
    return "; ".join(parts)


def statements(found: Mapping[str, Mapping[str, Any]]) -> list[tuple[str, str, str]]:
    """Each statement of the paper on breakup, what was found, and whether it holds."""
    rows: list[tuple[str, str, str]] = []
    leading, random = found.get("leading"), found.get("random")
    if leading is not None:
        rows += leading_statements(leading)
    if "sparse" in found:
        rows.append(exponential_statement(found["sparse"], "packing 0.2", PAPER_LINEAR["sparse"]))
    if leading is not None and random is not None:
        ends = [each["events"]["eps_x = 1"] for each in (leading, random)]
        paper = PAPER_SLOWER[DENSE.packing]
        said = f"ad hoc disturbance: {paper} times longer to eps_x = 1"
        if None in ends:
            missing = ["leading", "random"][ends.index(None)]
            rows.append((said, f"{missing} has not reached it", "not known yet"))
        else:
            slower = ends[1] / ends[0]
            holds = 0.5 * paper < slower < 2.0 * paper
            rows.append((said, f"{slower:.2f} times ({ends[1]:.0f})", answer(holds)))
    eight, twelve = found.get("eight"), found.get("twelve")
    if eight is not None and twelve is not None:
        lost = [each["events"]["out of order"] for each in (eight, twelve)]
        text = [
            f"{name}: " + ("in order" if time is None else f"out of order at {time:.0f}")
            for name, time in zip(("N = 8", "N = 12"), lost, strict=True)
        ]
        over = finished("eight", eight), finished("twelve", twelve)
        known = lost[0] is not None or all(over) or (over[0] and lost[1] is not None)
        holds = lost[0] is None and lost[1] is not None
        rows.append(
            (
                "Fig. 1: N = 8 stays in order, N = 12 in the same tube does not",
                "; ".join(text),
                answer(holds) if known else "not known yet",
            )
        )
    return rows


def leading_statements(leading: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    """Those on the fastest mode."""
    events, reached = leading["events"], leading["time"]
    rows = [exponential_statement(leading, "packing 0.7", PAPER_LINEAR["leading"])]
    opposed = [at(leading, "opposition", time) for time in PAPER_TIMES[:2]]
    said = "t <= 610: wave of two cells, neighbours turn oppositely (Fig. 12)"
    if opposed[1] is None:
        text = "" if opposed[0] is None else f"{opposed[0]:+.2f} at first"
        rows.append((said, text, "not known yet"))
    else:
        rows.append((said, f"{opposed[1]:+.2f} (1: oppositely)", answer(opposed[1] > 0.0)))
    lost = events["out of order"]
    said = f"broken up after {PAPER_TIMES[3]:.0f}, disordered at {PAPER_TIMES[-1]:.0f} (Fig. 12)"
    if lost is None:
        over = reached >= PAPER_TIMES[-1]
        rows.append((said, f"in order until {reached:.0f}", "no" if over else "not known yet"))
    else:
        holds = 0.5 * PAPER_TIMES[3] < lost < 1.5 * PAPER_TIMES[-1]
        rows.append((said, f"out of order at {lost:.0f}", answer(holds)))
    correction = leading["largest_volume_correction"]
    text = f"{correction:.1e} at most, that of the first shapes left out"
    rows.append(("correction of the volume: below 1e-5 r0 a step", text, answer(correction < 1e-5)))
    return rows


def exponential_statement(
    content: Mapping[str, Any], where: str, paper: float
) -> tuple[str, str, str]:
    """Up to which eps_x a mode grows as the linear theory says."""
    left = content["events"]["not exponential"]
    said = f"the mode grows as exp(alpha t) until eps_x = {paper}, {where} (Fig. 11)"
    grown = content["eps_x"][0] * np.exp(content["growth_rate"] * (left or content["time"]))
    if left is None:
        text = f"within {CLOSE:.0%} so far, until eps_x = {content['eps_x'][1]:.2f}"
        return said, text, answer(True) if grown > paper else "not known yet"
    text = f"within {CLOSE:.0%} until {grown:.2f} (t = {left:.0f})"
    return said, text, answer(grown > 0.5 * paper)


def answer(holds: bool) -> str:
    return "yes" if holds else "no"


def course(page: Page, leading: Mapping[str, Any]) -> None:
    """The fastest mode at the paper's times."""
    page.heading("The fastest mode at the paper's times")
    measures = ("eps_x", "inclination", "radial", "opposition", "spacing", "cell_distance")
    rows = []
    for time, said in zip(PAPER_TIMES, PAPER_SAYS, strict=True):
        names = (*measures, "film_share", "extra_pressure_drop")
        values = [at(leading, name, time) for name in names]
        rows.append(
            [f"{time:.0f}", said, *("" if each is None else f"{each:.4g}" for each in values)]
        )
    columns = ("eps_x", "inclination, degrees", "off the axis, r0", "opposition", "spacing")
    gaps = ("smallest gap, r0", "energy of films", "extra pressure drop")
    page.table(("t", "the paper", *columns, *gaps), rows)
    page.text(
        """
Opposition: 1 where neighbours turn oppositely, -1 where they turn alike. Spacing: largest deviation
of the axial distance of two neighbours (in the order that cells have then) from the period, over
it; a train is called out of order where that exceeds a half. Energy of films: that of the
repulsion, relative to the elastic energy of all membranes. Extra pressure drop: relative to that of
plasma alone at the same flow rate. Empty: not reached yet.
"""
    )


def figure(page: Page, found: Mapping[str, Mapping[str, Any]]) -> None:
    """eps_x as in Fig. 11, and the order and the pressure drop."""
    drawn = plain_figure(10.0, 3.4)
    left, middle, right = drawn.subplots(1, 3)
    for name, content in found.items():
        times, measures = np.array(content["times"]), content["measures"]
        color = COLORS[name]
        left.semilogy(times, measures["eps_x"], color=color, label=name)
        middle.plot(times, measures["spacing"], color=color, label=name)
        right.plot(
            times, 100.0 * np.array(measures["extra_pressure_drop"]), color=color, label=name
        )
        if name in PAPER_LINEAR:
            exponential = content["eps_x"][0] * np.exp(content["growth_rate"] * times)
            left.semilogy(times, exponential, "k:", linewidth=1.0, label=f"{name}, exp(alpha t)")
    for axes, text in (
        (left, "eps_x, r0"),
        (middle, "deviation of the spacing, periods"),
        (right, "pressure drop beyond that of plasma, %"),
    ):
        axes.set_title(text, fontsize=9, loc="left")
        axes.set_xlabel("t, r0/U")
    left.legend(frameon=False, fontsize=8)
    page.figure(drawn, "Size of the disturbance, order of the train, and pressure drop over time")


def pictures(page: Page, found: Mapping[str, Mapping[str, Any]]) -> None:
    """The cells at a few times, as in Figs. 1 and 12."""
    for name, content in found.items():
        path = FOLDER / f"breakup-{name}.png"
        if path.exists():
            page.parts.append(
                f"![The cells in time, {name}]({path.name})\n\n*{name}: {CASES[name].shows};"
                f" {state(name, content)}*"
            )
