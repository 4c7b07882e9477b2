"""The paper's statements about simulations beside what is kept of ours (Figs. 1, 4, 9, 11, 12).

What is kept are the reports of simulations at M = 12 that take hours, and measures of short ones.
"""

from collections.abc import Mapping
from typing import Any

from celltrain.paper.finding import Finding

#: Within how much of the linear theory a simulation follows it.
FOLLOWS = 0.05
#: eps_x up to which the paper's modes grow exponentially, by the report's name.
EXPONENTIAL = {"leading": (0.7, 0.5), "sparse": (0.2, 5.0)}
#: Within what factor of the paper's a time or size may be called its own.
FACTOR = 2.0
#: The paper's time of the pairwise rotation, and of disorder, in r0/U.
OPPOSED, DISORDER = 610.0, (970.0, 1410.0)
#: The paper's factor for displaced cells.
SLOWER = 2.7

Report = Mapping[str, Any]


def early_findings(panels: Mapping[str, Report]) -> list[Finding]:
    """Figs. 4 and 9: how simulations of v_eta and v_alpha follow the linear theory.

    **Arguments:** `panels`: measures by figure; `off` the largest distances from the linear theory
    of v_eta and of v_alpha, and of v_alpha from exp(alpha t).
    """
    small = panels["Fig. 4"]["off"]
    large = [each["off"][0] for name, each in panels.items() if name.startswith("Fig. 9")]
    return [
        Finding(
            "P5",
            "simulated, v_eta follows exp(A t), and v_alpha exp(alpha t)",
            f"within {small[0]:.1%} and {small[2]:.1%}",
            max(small[0], small[2]) < FOLLOWS,
        ),
        Finding(
            "P14",
            "simulated, eps = 0.1 in v_eta leads to no growth beyond the linear theory",
            f"within {max(large):.1%} of it",
            max(large) < FOLLOWS,
        ),
    ]


def breakup_findings(reports: Mapping[str, Report]) -> list[Finding]:
    """Figs. 1, 11 and 12, from the reports of the five simulations by name."""
    leading, random = reports["leading"], reports["random"]
    found = []
    for name, (packing, paper) in EXPONENTIAL.items():
        size = _size(reports[name], reports[name]["events"]["not exponential"])
        found.append(
            Finding(
                "P16",
                f"simulated, packing {packing:g}: the mode grows as exp(alpha t) until eps_x ="
                f" {paper:g}",
                f"within 20 % until {size:.2f}",
                paper / FACTOR < size < paper * FACTOR,
            )
        )
    slower = random["events"]["eps_x = 1"] / leading["events"]["eps_x = 1"]
    found.append(
        Finding(
            "P16",
            f"simulated, packing 0.7: displaced cells take {SLOWER:g} times as long to eps_x = 1",
            f"{slower:.2f} times",
            SLOWER / FACTOR < slower < SLOWER * FACTOR,
        )
    )
    opposed = _at(leading, "opposition", OPPOSED)
    lost = leading["events"]["out of order"]
    eight, twelve = (reports[name]["events"]["out of order"] for name in ("eight", "twelve"))
    return [
        *found,
        Finding(
            "P17",
            "D = 10, packing 0.7: by t = 61 neighbours turn oppositely",
            f"opposition {opposed:+.2f} (1: oppositely, -1: alike)",
            opposed > 0.0,
        ),
        Finding(
            "P17",
            "it breaks up after t = 97 and is disordered at 141, within a factor",
            f"out of order at {lost / 10.0:.0f}" if lost else "stays in order",
            lost is not None and 0.5 * DISORDER[0] < lost < 1.5 * DISORDER[1],
        ),
        Finding(
            "P18",
            "in the same tube N = 8 stays in order and N = 12 breaks up",
            f"N = 8: {_order(eight)}; N = 12: {_order(twelve)}",
            eight is None and twelve is not None,
        ),
    ]


def _order(lost: float | None) -> str:
    return "in order" if lost is None else f"out of order at {lost / 10.0:.0f}"


def _at(report: Report, measure: str, time: float) -> float:
    """A measure at the frame nearest to a time."""
    times = report["times"]
    place = min(range(len(times)), key=lambda each: abs(times[each] - time))
    return float(report["measures"][measure][place])


def _size(report: Report, time: float | None) -> float:
    """eps_x at a time, at the last one if it is None."""
    return _at(report, "eps_x", report["times"][-1] if time is None else time)
