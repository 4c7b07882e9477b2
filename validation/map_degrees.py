"""Growth rates over the paper's map at several degrees: is the reported error honest?

The growth rates are kept in docs/validation/data/map-degrees.json; cases that the file lacks are
computed, each anew by removing the file. What would be reported is found by the package's own rule
from the values that are kept.
"""

import argparse
import json
import multiprocessing
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass

import numpy as np
from degrees import LADDER
from page import FOLDER, Page, plain_figure

from celltrain import Base, Train, stability, steady
from celltrain.stability.convergence import ACCURACY, NUMBERS, AbscissaLadder
from celltrain.steady.degree import DEGREES, Convergence

FILE = FOLDER / "data" / "map-degrees.json"
DIAMETERS = tuple(float(each) for each in range(6, 13))
PACKINGS = tuple(round(0.2 + 0.05 * step, 2) for step in range(11))
CELLS = 8
# Narrower tubes, beside the map.
NARROW = tuple((diameter, packing) for diameter in (3.0, 4.0, 5.0) for packing in (0.1, 0.2, 0.3))
# Share of the trains whose error is to cover the value at the highest degree.
ASKED = 0.95
# Degrees up to which the map is computed, and the trains beside it.
HIGHEST, NARROW_HIGHEST = LADDER[-1], 64
FIXED = DEGREES[0]
PERCENT = f"{100.0 * ACCURACY:g} %"
COLORS = ("#0072B2", "#56B4E9", "#009E73", "#F0E442", "#E69F00", "#D55E00", "#CC79A7")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of this study."""
    group = parser.add_argument_group("map")
    group.add_argument(
        "--workers",
        type=int,
        default=1,
        help="processes that compute cases which the kept data lack (default: 1)",
    )


@dataclass(frozen=True)
class Case:
    """One train by degree: largest growth rate in U/r0, where, and the residual in U."""

    diameter: float
    packing: float
    alpha: tuple[float, ...]
    frequency: tuple[float, ...]
    azimuthal_number: tuple[int, ...]
    wave_number: tuple[int, ...]
    residual: tuple[float, ...]
    seconds: float

    @property
    def best(self) -> float:
        """alpha at the highest degree."""
        return self.alpha[-1]

    @property
    def degrees(self) -> tuple[int, ...]:
        """The degrees of the values."""
        return DEGREES[: len(self.alpha)]

    def convergence(self, degree: int | None) -> Convergence:
        """What is reported of the case at a degree, or without one at the usual accuracy."""
        train = Train(diameter=self.diameter, packing=self.packing, cells=CELLS, degree=degree)
        return Known(self, train).resolved(ACCURACY, estimate_error=True)


class Known(AbscissaLadder):
    """The package's rule for the degree, with growth rates that are known already."""

    def __init__(self, case: Case, train: Train) -> None:
        super().__init__(train, NUMBERS)
        self._alpha = dict(zip(case.degrees, case.alpha, strict=True))

    def base(self, degree: int, iteration: object = None) -> Base:  # type: ignore[override]
        """Not needed."""
        return None  # type: ignore[return-value]

    def abscissa(self, degree: int) -> float:
        """alpha at a degree."""
        return self._alpha[degree]


def compute(place: tuple[float, float]) -> Case:
    """One train at all degrees, each continued from the one before."""
    begin = time.perf_counter()
    diameter, packing = place
    base: Base | None = None
    found = []
    highest = NARROW_HIGHEST if place in NARROW else HIGHEST
    for degree in (each for each in DEGREES if each <= highest):
        train = Train(diameter=diameter, packing=packing, cells=CELLS, degree=degree)
        base = steady(train, start=base, estimate_error=False)
        result = stability(base, azimuthal_numbers=NUMBERS, estimate_error=False)
        lead = result.leading
        found.append(
            (
                lead.growth_rate,
                abs(lead.frequency),
                lead.azimuthal_number,
                lead.wave_number,
                base.residual,
            )
        )
    columns = (tuple(column) for column in zip(*found, strict=True))
    return Case(diameter, packing, *columns, round(time.perf_counter() - begin, 1))  # type: ignore[arg-type]


def kept() -> dict[tuple[float, float], Case]:
    """The cases of the file."""
    if not FILE.is_file():
        return {}
    cases = [
        Case(
            **{
                name: tuple(value) if isinstance(value, list) else value
                for name, value in each.items()
            }
        )
        for each in json.loads(FILE.read_text())
    ]
    return {(case.diameter, case.packing): case for case in cases}


def keep(cases: dict[tuple[float, float], Case]) -> None:
    """Write the file: a case a line, and whole at any moment."""
    FILE.parent.mkdir(parents=True, exist_ok=True)
    lines = ",\n".join(json.dumps(asdict(cases[place])) for place in sorted(cases))
    draft = FILE.with_suffix(".part")
    draft.write_text(f"[\n{lines}\n]\n")
    draft.replace(FILE)


def computed(places: list[tuple[float, float]], workers: int) -> Iterator[Case]:
    """The cases one after another, or by several processes."""
    if workers <= 1:
        yield from map(compute, places)
        return
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=context) as pool:
        yield from pool.map(compute, places)


def all_cases(page: Page, workers: int) -> tuple[list[Case], list[Case]]:
    """The whole map, and the trains beside it, computed where they are not kept."""
    cases = kept()
    places = [(diameter, packing) for diameter in DIAMETERS for packing in PACKINGS]
    missing = [place for place in places if place not in cases]
    missing += [
        place for place in NARROW if place not in cases or cases[place].degrees[-1] < NARROW_HIGHEST
    ]
    for case in computed(missing, workers):
        cases[case.diameter, case.packing] = case
        keep(cases)
        page.log(f"D = {case.diameter:g}, packing {case.packing:g}: {case.seconds:g} s")
    return [cases[place] for place in places], [cases[place] for place in NARROW]


@dataclass(frozen=True)
class Verdict:
    """What is reported of a case, and how far it is from the value at the highest degree."""

    case: Case
    degree: int
    alpha: float
    error: float

    @property
    def off(self) -> float:
        """Distance from alpha at the highest degree."""
        return abs(self.alpha - self.case.best)

    @property
    def covered(self) -> bool:
        """Whether the error covers that distance."""
        return self.off <= self.error


def verdict(case: Case, degree: int | None) -> Verdict:
    """What is reported at a degree, or at the usual accuracy."""
    found = case.convergence(degree)
    return Verdict(case, found.degree, case.alpha[DEGREES.index(found.degree)], found.error)


def study(workers: int = 1) -> None:
    page = Page("map", "Errors of growth rates over the map")
    page.text(
        f"""
The {len(DIAMETERS) * len(PACKINGS)} trains of the paper's map: D = {DIAMETERS[0]:g} to
{DIAMETERS[-1]:g} r0 in steps of 1, packing {PACKINGS[0]:g} to {PACKINGS[-1]:g} in steps of 0.05, N
= {CELLS}, viscosity ratio 1. alpha, the largest growth rate of azimuthal numbers 0 to
{max(NUMBERS)}, at M = {", ".join(str(each) for each in LADDER)}; the value at M =
{HIGHEST} stands for the exact one, in narrower tubes that at M = {NARROW_HIGHEST}. Two questions:
does the error that is reported cover it, at the default accuracy ({PERCENT} or 1e-4 U/r0), where
the degree rises until that is reached, and at the fixed degree {FIXED}, that of the paper; and
which degrees does the default take? Asked for: covered in
{100.0 * ASKED:g} % of the trains or more.
"""
    )
    cases, narrow = all_cases(page, workers)
    usual = [verdict(case, None) for case in cases]
    fixed = [verdict(case, FIXED) for case in cases]
    _coverage(page, usual, fixed)
    _degrees(page, usual)
    _convergence(page, cases)
    _table(page, "All trains of the map", usual, fixed)
    beside = [[verdict(case, degree) for case in narrow] for degree in (None, FIXED)]
    _table(page, "Narrower tubes", *beside)
    page.text(
        f"""
The constants of the rule were chosen with the trains of the map in view; these nine are none of
them, and the narrowest are the hardest. {_missed("At the default accuracy", beside[0])}
{_missed(f"At degree {FIXED}", beside[1])}
"""
    )
    _figure(page, usual, fixed)
    page.text(
        f"""
The growth rates are kept in `data/{FILE.name}`, and `python validation/run.py map` makes this page
from them; trains that the file lacks it computes, with `--workers 2` by two processes, and without
the file all of them. What is reported is found by the package's own rule
(`celltrain.steady.degree`) from the growth rates that are kept.
"""
    )
    page.write()


def _coverage(page: Page, usual: list[Verdict], fixed: list[Verdict]) -> None:
    page.heading("Is the error honest?")
    rows = []
    for name, verdicts in (
        ("default accuracy", usual),
        (f"fixed degree {FIXED}", fixed),
    ):
        covered = sum(each.covered for each in verdicts)
        share = covered / len(verdicts)
        ratios = [each.error / each.off for each in verdicts if each.off > 0.0]
        rows.append(
            (
                name,
                f"{covered} of {len(verdicts)} ({100.0 * share:.1f} %)",
                f"{100.0 * ASKED:g} %",
                "yes" if share >= ASKED else "NO",
                f"{np.median(ratios):.1f}",
                f"{max(each.off for each in verdicts):.1e}",
            )
        )
    page.table(
        (
            "",
            f"error covers alpha at M = {HIGHEST}",
            "asked for",
            "reached",
            "error over true error, median",
            "largest true error, U/r0",
        ),
        rows,
    )
    page.text(_missed("At the default accuracy", usual))
    page.text(_missed(f"At degree {FIXED}", fixed))
    within = [each for each in usual if each.off <= ACCURACY * max(abs(each.case.best), 1e-2)]
    page.text(
        f"""
The default keeps what it promises, {PERCENT} or 1e-4 U/r0 of alpha at M = {HIGHEST}, in
{len(within)} of {len(usual)} trains.
"""
    )


def _missed(where: str, verdicts: list[Verdict]) -> str:
    """Which errors do not cover the true one."""
    missed = "; ".join(
        f"D = {each.case.diameter:g}, packing {each.case.packing:g} (M = {each.degree}:"
        f" {each.alpha:.2e}, error {each.error:.1e}, true error {each.off:.1e})"
        for each in verdicts
        if not each.covered
    )
    return f"{where} these are not covered: {missed}." if missed else f"{where} all are covered."


def _degrees(page: Page, usual: list[Verdict]) -> None:
    page.heading("Which degree the default takes")
    taken = Counter(each.degree for each in usual)
    page.table(
        ("M", *(str(degree) for degree in LADDER)),
        [("trains", *(taken[degree] for degree in LADDER))],
    )
    page.text(
        """
Three degrees are the fewest that tell an error, so none stops below M = 20. Down: packing; across:
D.
"""
    )
    by_place = {(each.case.diameter, each.case.packing): each.degree for each in usual}
    page.table(
        ("packing", *(f"{diameter:g}" for diameter in DIAMETERS)),
        [
            (f"{packing:g}", *(by_place[diameter, packing] for diameter in DIAMETERS))
            for packing in PACKINGS
        ],
    )


def _convergence(page: Page, cases: list[Case]) -> None:
    page.heading("What a degree leaves")
    page.text(f"Distances of alpha from its value at M = {HIGHEST} over all trains, U/r0.")
    off = np.array([[abs(a - case.best) for a in case.alpha[:-1]] for case in cases])
    page.table(
        ("", *(f"M = {degree}" for degree in LADDER[:-1])),
        [
            ("median", *(f"{each:.1e}" for each in np.median(off, axis=0))),
            ("nine in ten are below", *(f"{each:.1e}" for each in np.quantile(off, 0.9, axis=0))),
            ("largest", *(f"{each:.1e}" for each in off.max(axis=0))),
        ],
    )
    worst = max(max(case.residual) for case in cases)
    other = [
        case
        for case in cases
        if (case.azimuthal_number[0], case.wave_number[0])
        != (case.azimuthal_number[-1], case.wave_number[-1])
    ]
    turned = [case for case in cases if case.alpha[0] * case.best < 0.0]
    page.text(
        f"""
At M = {FIXED} another mode leads than at M = {HIGHEST} in {len(other)} trains
({_names(other)}), and alpha has the other sign in {len(turned)} ({_names(turned)}).
Largest residual of a steady train: {worst:.0e} U.
"""
    )


def _names(cases: list[Case]) -> str:
    return "; ".join(f"D = {case.diameter:g}, packing {case.packing:g}" for case in cases)


def _table(page: Page, title: str, usual: list[Verdict], fixed: list[Verdict]) -> None:
    page.heading(title)
    page.table(
        (
            "D",
            "packing",
            f"alpha, M = {FIXED}",
            "error",
            "m, j",
            "alpha, default",
            "error",
            "M",
            f"alpha, M = {max(one.case.degrees[-1] for one in usual)}",
            "m, j",
        ),
        [
            (
                f"{one.case.diameter:g}",
                f"{one.case.packing:g}",
                f"{two.alpha:+.5f}",
                f"{two.error:.1e}",
                f"{one.case.azimuthal_number[0]}, {one.case.wave_number[0]}",
                f"{one.alpha:+.5f}",
                f"{one.error:.1e}",
                one.degree,
                f"{one.case.best:+.5f}",
                f"{one.case.azimuthal_number[-1]}, {one.case.wave_number[-1]}",
            )
            for one, two in zip(usual, fixed, strict=True)
        ],
    )


def _figure(page: Page, usual: list[Verdict], fixed: list[Verdict]) -> None:
    figure = plain_figure(9.6, 4.0)
    left, right = figure.subplots(1, 2)
    least = 1e-8
    for verdicts, color, name in (
        (fixed, "#D55E00", f"fixed degree {FIXED}"),
        (usual, "#0072B2", "default accuracy"),
    ):
        left.loglog(
            [max(each.off, least) for each in verdicts],
            [each.error for each in verdicts],
            "o",
            color=color,
            markersize=4,
            label=name,
        )
    span = (least, 1e-2)
    left.plot(span, span, color="0.5", linewidth=0.8)
    left.set_xlim(*span)
    left.set_ylim(3e-6, 1e-2)
    left.set_xlabel(f"true error: distance from M = {HIGHEST}, $U/r_0$")
    left.set_ylabel("error reported, $U/r_0$")
    left.set_title("Honest above the line", fontsize=10)
    left.legend(fontsize=8, frameon=False)
    for diameter, color in zip(DIAMETERS, COLORS, strict=True):
        here = [each for each in usual if each.case.diameter == diameter]
        right.errorbar(
            [each.case.packing for each in here],
            [1e3 * each.alpha for each in here],
            [1e3 * each.error for each in here],
            fmt=".-",
            color=color,
            linewidth=1.0,
            capsize=2,
            label=f"D = {diameter:g}",
        )
    right.axhline(0.0, color="0.6", linewidth=0.8)
    right.set_xlabel("packing")
    right.set_ylabel("alpha, $10^{-3} U/r_0$")
    right.set_title("Growth rates at the default accuracy, with their errors", fontsize=10)
    right.legend(fontsize=8, frameon=False)
    page.figure(
        figure, "Errors reported and true ones; and the growth rates of the map with their errors"
    )
