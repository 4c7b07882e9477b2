"""How steady trains and their linear dynamics depend on the degree and on each rule."""

import math
from dataclasses import dataclass, replace

import numpy as np
from degrees import LADDER
from page import Page, plain_figure

from celltrain import Base, Stability, Train, stability, steady
from celltrain.stability import (
    NORMS,
    OrthonormalNorm,
    block_spectrum,
    linear_blocks,
    neutral_space,
    numerical_abscissa,
)
from celltrain.steady.problem import SteadyProblem

CELLS = 8
# Diameter and packing of the trains, the first of which the other sections take.
TRAINS = ((6.0, 0.2), (3.0, 0.2), (6.0, 0.5), (6.0, 0.7))
# By degree U_c and alpha of a separate trial implementation of the equations, with its own rules.
TRIAL_VELOCITY = {
    (6.0, 0.2): {
        12: 1.771955,
        16: 1.774960,
        20: 1.775435,
        24: 1.775493,
        32: 1.775520,
    }
}
TRIAL_ALPHA = {
    (6.0, 0.2): {
        12: 0.011784,
        16: 0.014173,
        20: 0.013877,
        24: 0.013820,
        32: 0.013779,
        40: 0.013779,
        48: 0.013779,
    },
    (3.0, 0.2): {
        12: 0.0365,
        16: 0.0328,
        20: 0.0302,
        24: 0.0280,
        32: 0.0258,
        40: 0.0253,
        48: 0.0251,
    },
}
# An older one in three dimensions: eta of disturbances alike in all cells, orthonormal.
TRIAL_ETA = {12: 1.741, 16: 2.03, 20: 2.22}
# What is expected to agree: U_c relatively, alpha in U/r0 (half of the trial's last digit, and its
# rules), eta relatively.
SAME_VELOCITY, SAME_ALPHA, SAME_ETA = 1e-6, {(6.0, 0.2): 2e-6, (3.0, 0.2): 1e-4}, 0.02
# The modes that matter have few azimuths; the numerical abscissa's, too.
NUMBERS = range(4)
# Nodes of the polar rule per degree, radial and around, what the trial's error of the blocks and of
# alpha was (M = 12), and the rule that stands for the exact one.
POLAR = {
    (7 / 3, 3.5): (7e-3, 6e-6),
    (4.0, 5.0): (4e-6, 9e-8),
    (5.0, 6.0): (5e-8, 3e-10),
    (7.0, 10.0): (1e-11, 1e-13),
}
EXACT = (10.0, 14.0)
POLAR_DEGREES = (12, 24)
RULES_DEGREE = 24


@dataclass(frozen=True)
class Answer:
    """The numbers that are compared."""

    base: Base
    result: Stability

    @property
    def cell_velocity(self) -> float:
        """Velocity of the train, U."""
        return self.base.cell_velocity

    @property
    def alpha(self) -> float:
        """Spectral abscissa, U/r0."""
        return self.result.spectral_abscissa

    @property
    def following(self) -> float:
        """The next growth rate that is not the same mode's conjugate."""
        rates = [mode.growth_rate for mode in self.result.modes if not mode.neutral]
        return next(rate for rate in rates[1:] if abs(rate - rates[0]) > 1e-9)

    @property
    def place(self) -> str:
        """m and j of the leading mode."""
        return f"{self.result.leading.azimuthal_number}, {self.result.leading.wave_number}"

    def eta(self, norm: str) -> float:
        """Numerical abscissa in one of the norms, U/r0."""
        return self.result.numerical_abscissas[norm]

    def uniform_eta(self) -> float:
        """Numerical abscissa of disturbances that are alike in all cells, orthonormal, U/r0."""
        grams = OrthonormalNorm().grams(self.base.coefficients, NUMBERS)
        return max(
            numerical_abscissa(self.result.blocks[m][0], gram)[0] for m, gram in grams.items()
        )


def answer(train: Train, start: Base | None) -> Answer:
    """The steady train and its dynamics."""
    base = steady(train, start=start)
    result = stability(base, azimuthal_numbers=NUMBERS, estimate_error=False)
    return Answer(base, result)


def study() -> None:
    page = Page("convergence", "Convergence with degree and rules")
    page.text(
        f"""
N = {CELLS}, viscosity ratio 1; rates in U/r0, azimuthal numbers 0 to {max(NUMBERS)}. alpha:
spectral abscissa, neutral modes set aside, with m and j of its mode; "next": the next growth rate;
eta: numerical abscissa in the paper's norm. "Expected" are the numbers of a separate trial
implementation of the same equations with rules of its own: cell velocities equal to
{SAME_VELOCITY:.0e}, alpha to {SAME_ALPHA[6.0, 0.2]:.0e} U/r0 at D = 6 and to
{SAME_ALPHA[3.0, 0.2]:.0e} U/r0, its last digit, at D = 3.
"""
    )
    found: dict[tuple[float, float], dict[int, Answer]] = {}
    for place in TRAINS:
        start: Base | None = None
        found[place] = {}
        for degree in LADDER:
            train = Train(diameter=place[0], packing=place[1], cells=CELLS, degree=degree)
            found[place][degree] = answer(train, start)
            start = found[place][degree].base
        page.log(f"D = {place[0]:g}, packing {place[1]:g}")
        _degrees(page, place, found[place])
    _summary(page, found)
    _usual(page, found)
    _norms(page, found[TRAINS[0]])
    _polar(page, found)
    _rules(page, found[TRAINS[0]][RULES_DEGREE])
    _figure(page, found)
    page.write()


def _degrees(page: Page, place: tuple[float, float], answers: dict[int, Answer]) -> None:
    page.heading(f"Degree, D = {place[0]:g}, packing {place[1]:g}")
    velocities, alphas = TRIAL_VELOCITY.get(place, {}), TRIAL_ALPHA.get(place, {})
    columns = ["M", "U_c"]
    columns += ["expected"] if velocities else []
    columns += ["alpha"]
    columns += ["expected"] if alphas else []
    columns += ["m, j", "next", "eta", "left out by the degree, U", "residual, U"]
    rows = []
    for degree, each in answers.items():
        row: list[object] = [degree, f"{each.cell_velocity:.6f}"]
        row += [f"{velocities[degree]:.6f}" if degree in velocities else ""] if velocities else []
        row += [f"{each.alpha:.6f}"]
        row += [f"{alphas[degree]:g}" if degree in alphas else ""] if alphas else []
        row += [
            each.place,
            f"{each.following:.5f}",
            f"{each.eta('paper'):.4f}",
            f"{each.base.truncation_error:.1e}",
            f"{each.base.residual:.0e}",
        ]
        rows.append(row)
    page.table(columns, rows)
    if not alphas:
        return
    off = max(abs(each.alpha - alphas[degree]) for degree, each in answers.items())
    words = f"The largest difference from what is expected is {off:.0e} U/r0 in alpha"
    holds = off <= SAME_ALPHA[place]
    if velocities:
        moved = max(
            abs(answers[degree].cell_velocity / expected - 1.0)
            for degree, expected in velocities.items()
        )
        words += f" and {moved:.0e} in U_c"
        holds = holds and moved <= SAME_VELOCITY
    page.text(f"{words}: {'as expected' if holds else 'NOT as expected'}.")


def _summary(page: Page, found: dict[tuple[float, float], dict[int, Answer]]) -> None:
    page.heading(f"What each degree leaves, against M = {LADDER[-1]}")
    page.text("Relative differences; of alpha in parts of itself, of the growth rate that leads.")
    rows = []
    for (diameter, packing), answers in found.items():
        finest = answers[LADDER[-1]]
        for name, value in (
            ("U_c", lambda each: each.cell_velocity),
            ("alpha", lambda each: each.alpha),
            ("eta", lambda each: each.eta("paper")),
        ):
            rows.append(
                (
                    f"{diameter:g}, {packing:g}",
                    name,
                    *(
                        f"{100.0 * (value(answers[degree]) / value(finest) - 1.0):+.2g} %"
                        for degree in LADDER[:-1]
                    ),
                )
            )
    page.table(("D, packing", "", *(f"M = {degree}" for degree in LADDER[:-1])), rows)


def _usual(page: Page, found: dict[tuple[float, float], dict[int, Answer]]) -> None:
    page.heading("The degree that is taken without one being given")
    page.text(
        f"""
At the default accuracy, 1 % or 1e-4 U/r0. The error is expected to cover the difference from M =
{LADDER[-1]}. [The page on the map](map.md) has this for 77 trains.
"""
    )
    rows, missed = [], []
    for (diameter, packing), answers in found.items():
        train = Train(diameter=diameter, packing=packing, cells=CELLS)
        result = stability(train, azimuthal_numbers=NUMBERS)
        finest = answers[LADDER[-1]].alpha
        off = abs(result.spectral_abscissa - finest)
        if off > result.error_estimate:
            steps = np.diff([answers[degree].alpha for degree in LADDER[-4:]])
            missed.append(
                f"D = {diameter:g}, packing {packing:g}. There the steps from M = {LADDER[-4]} on"
                f" change alpha by {', '.join(f'{step:+.1e}' for step in steps)}: it converges"
                " slowly and unevenly, and up to the degree taken it seems to do so faster than it"
                f" does. The difference from M = {LADDER[-1]} is {100.0 * off / finest:.2g} %."
            )
        rows.append(
            (
                f"{diameter:g}, {packing:g}",
                result.base.train.degree,
                f"{result.spectral_abscissa:.6f}",
                f"{result.error_estimate:.1e}",
                f"{finest:.6f}",
                f"{off:.1e}",
                "yes" if off <= result.error_estimate else "NO",
            )
        )
        page.log(f"D = {diameter:g}, packing {packing:g}: degree {result.base.train.degree}")
    page.table(
        (
            "D, packing",
            "M",
            "alpha",
            "its error, reported",
            f"alpha, M = {LADDER[-1]}",
            "difference",
            "covered",
        ),
        rows,
    )
    if missed:
        page.text(f"Not covered: {' '.join(missed)}")


def _norms(page: Page, answers: dict[int, Answer]) -> None:
    diameter, packing = TRAINS[0]
    page.heading(f"Numerical abscissa, D = {diameter:g}, packing {packing:g}")
    page.text(
        f"""
It depends on the norm, and on the degree more than alpha does: but it converges. [Norms](norms.md)
has the same for growth at later times. The older trial implementation took disturbances that are
alike in all cells (q = 0); those that grow fastest need not be. m, j: of the disturbance that grows
fastest in the paper's norm. Expected is agreement to {100.0 * SAME_ETA:g} %.
"""
    )
    names = [norm.name for norm in NORMS]
    page.table(
        ("M", *(f"eta, {name}" for name in names), "m, j", "orthonormal, q = 0", "expected, q = 0"),
        [
            (
                degree,
                *(f"{each.eta(name):.4f}" for name in names),
                f"{each.result.transient.azimuthal_number}, {each.result.transient.wave_number}",
                f"{each.uniform_eta():.4f}",
                f"{TRIAL_ETA[degree]:g}" if degree in TRIAL_ETA else "",
            )
            for degree, each in answers.items()
        ],
    )


def _polar(page: Page, found: dict[tuple[float, float], dict[int, Answer]]) -> None:
    page.heading("The polar rule on the cell itself")
    page.text(
        f"""
Nodes per degree, radial by around; the default is 4 by 5, and in proportion more for longer cells.
Errors against {EXACT[0]:g} by {EXACT[1]:g}, at the same shape: of all blocks (m = 0 to
{max(NUMBERS)}, all q) the norm of the difference over that of the blocks, and the largest
difference of an element; and the difference of alpha; both in U/r0. "Expected" is what the trial
implementation had at D = 6, M = 12.
"""
    )
    rows = []
    for place in TRAINS[:2]:
        for degree in POLAR_DEGREES:
            base = found[place][degree].base
            exact, alpha = _by_polar(base, EXACT)
            usual_rules = SteadyProblem(base.train).rules(base.profile)
            default = (usual_rules.radial / degree, 2 * usual_rules.half_circle / degree)
            cases = dict(POLAR)
            # Of a cell as long as usual the default is among them.
            cases.setdefault(default, (math.nan, math.nan))
            for nodes, (blocks_expected, alpha_expected) in sorted(cases.items()):
                here, rate = _by_polar(base, nodes)
                error = np.sqrt(
                    sum(np.linalg.norm(here[m] - exact[m]) ** 2 for m in exact)
                    / sum(np.linalg.norm(exact[m]) ** 2 for m in exact)
                )
                worst = max(float(np.abs(here[m] - exact[m]).max()) for m in exact)
                usual = place == TRAINS[0] and degree == POLAR_DEGREES[0] and nodes in POLAR
                rows.append(
                    (
                        f"{place[0]:g}, {degree}",
                        f"{nodes[0]:.3g} x {nodes[1]:.3g}"
                        + (" (default)" if nodes == default else ""),
                        f"{error:.0e}",
                        f"{worst:.0e}",
                        f"{blocks_expected:.0e}" if usual else "",
                        f"{abs(rate - alpha):.0e}",
                        f"{alpha_expected:.0e}" if usual else "",
                    )
                )
            page.log(f"polar rule, D = {place[0]:g}, M = {degree}")
    page.table(
        (
            "D, M",
            "nodes per degree",
            "error of the blocks, norm",
            "worst element, U/r0",
            "expected",
            "error of alpha, U/r0",
            "expected",
        ),
        rows,
    )


def _by_polar(base: Base, nodes: tuple[float, float]) -> tuple[dict[int, np.ndarray], float]:
    """All blocks and alpha with a polar rule of so many nodes per degree."""
    degree = base.train.degree
    rules = replace(
        SteadyProblem(base.train).rules(base.profile),
        radial=round(nodes[0] * degree),
        half_circle=round(0.5 * nodes[1] * degree),
    )
    phases = 2.0 * np.pi * np.arange(CELLS // 2 + 1) / CELLS
    blocks = linear_blocks(base, phases, NUMBERS, rules=rules)
    return blocks, _abscissa(base, blocks)


def _abscissa(base: Base, blocks: dict[int, np.ndarray]) -> float:
    rates = []
    for m, each in blocks.items():
        for wave, block in enumerate(each):
            spectrum = block_spectrum(block, neutral_space(base, m, wave))
            rates.append(spectrum.eigenvalues[spectrum.kinds.index("")].real)
    return float(max(rates))


def _rules(page: Page, usual: Answer) -> None:
    train, base = usual.base.train, usual.base
    page.heading(
        f"The other rules, D = {train.tube.diameter:g}, packing {train.packing:g},"
        f" M = {train.degree}"
    )
    page.text(
        """
Each made finer alone; changes of U_c and alpha. Targets and energy with a steady train of their
own, the others at the same shape. What the rules leave is expected to be far below what the degree
leaves.
"""
    )
    rows = []
    for name, leaf in (("target points", "target_order"), ("points of the energy", "energy_order")):
        before = getattr(train.sizes, leaf)
        finer = answer(train.changed(**{leaf: 3 * before // 2}), base)
        rows.append(
            (
                name,
                f"{before} to {3 * before // 2}",
                f"{finer.cell_velocity - usual.cell_velocity:+.0e}",
                f"{finer.alpha - usual.alpha:+.0e}",
            )
        )
    problem = SteadyProblem(train)
    rules = problem.rules(base.profile)
    velocity = problem.state(base.profile, rules).cell_velocity
    phases = 2.0 * np.pi * np.arange(CELLS // 2 + 1) / CELLS
    for name, sizes in (
        ("points of the sources", ("sources",)),
        ("points of the nearest images", ("image_sources", "image_half_circle")),
    ):
        more = {size: 3 * getattr(rules, size) // 2 for size in sizes}
        finer_rules = replace(rules, **more)
        blocks = linear_blocks(base, phases, NUMBERS, rules=finer_rules)
        moved = problem.state(base.profile, finer_rules).cell_velocity - velocity
        steps = ", ".join(f"{getattr(rules, size)} to {more[size]}" for size in sizes)
        rows.append((name, steps, f"{moved:+.0e}", f"{_abscissa(base, blocks) - usual.alpha:+.0e}"))
    finer_rules = replace(rules, tolerance=1e-2 * rules.tolerance)
    blocks = linear_blocks(base, phases, NUMBERS, rules=finer_rules)
    moved = problem.state(base.profile, finer_rules).cell_velocity - velocity
    rows.append(
        (
            "tolerance of tail and wall",
            f"{rules.tolerance:.0e} to {finer_rules.tolerance:.0e}",
            f"{moved:+.0e}",
            f"{_abscissa(base, blocks) - usual.alpha:+.0e}",
        )
    )
    page.table(("rule", "from, to", "change of U_c", "change of alpha"), rows)


def _figure(page: Page, found: dict[tuple[float, float], dict[int, Answer]]) -> None:
    figure = plain_figure(9.0, 3.8)
    left, right = figure.subplots(1, 2)
    for place, answers in found.items():
        label = f"D = {place[0]:g}, packing {place[1]:g}"
        finest = answers[LADDER[-1]].alpha
        parts = [abs(answers[degree].alpha / finest - 1.0) for degree in LADDER[:-1]]
        left.semilogy(LADDER[:-1], parts, "o-", label=label)
        right.plot(LADDER, [answers[degree].eta("paper") for degree in LADDER], "o-", label=label)
    left.axhline(0.01, color="0.6", linewidth=0.8)
    left.set_title(f"alpha: distance from M = {LADDER[-1]}, relative", fontsize=10)
    right.set_title(r"eta, paper's norm, $U/r_0$", fontsize=10)
    right.set_ylim(0.0)
    for axes in (left, right):
        axes.set_xlabel("degree M")
        axes.set_xticks(LADDER)
        axes.legend(fontsize=8, frameon=False)
    page.figure(
        figure,
        "Growth rates against the degree: the spectral abscissa converges (line: the default"
        " accuracy, 1 %), and so does the numerical abscissa, at higher degrees",
    )
