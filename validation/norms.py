"""Transient growth against the degree in three norms: which of its measures converge."""

from dataclasses import dataclass

import numpy as np
from page import Page, plain_figure

from celltrain import Base, Train, stability, steady
from celltrain.stability import (
    Norm,
    PaperNorm,
    StrainNorm,
    SurfaceNorm,
    TransientGrowth,
    kreiss_constant,
    normed_blocks,
    transient_growth,
)

DEGREES = (12, 16, 20, 24, 32, 40)
TIMES = (0.1, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0)
UNTIL = 30.0
# Disturbances of higher azimuthal number grow less in all norms and degrees tried.
NUMBERS = range(4)
# A quantity has converged if the last step in the degree changes it by less than this part.
CONVERGED = 0.05
COLORS = {"paper": "#0072B2", "surface": "#009E73", "strain": "#D55E00"}


@dataclass(frozen=True)
class Measures:
    """Initial growth rate, growth at `TIMES`, passing peak and Kreiss constant in one norm."""

    growth: TransientGrowth
    at_times: np.ndarray
    kreiss: float


def measures(base: Base) -> dict[str, Measures]:
    """All of them in each norm; the train is one cell, all others are its images."""
    result = stability(base, azimuthal_numbers=NUMBERS, estimate_error=False)
    norms: tuple[Norm, ...] = (PaperNorm(), SurfaceNorm(), StrainNorm(base.train))
    found = {}
    for norm in norms:
        growth = transient_growth(result, norm=norm, until=UNTIL)
        # The logarithm of G between the samples is nearly straight.
        values = np.exp(np.interp(TIMES, growth.times, np.log(growth.growth)))
        blocks = normed_blocks(result, norm)
        leading = blocks[result.leading.azimuthal_number, result.leading.wave_number]
        found[norm.name] = Measures(growth, values, kreiss_constant(leading.matrix).constant)
    return found


def study() -> None:
    page = Page("norms", "Transient growth in three norms")
    page.text(
        """
D = 6 r0, packing 0.2, viscosity ratio 1, disturbances that are alike in all cells (q = 0),
azimuthal numbers 0 to 3; times in r0/U, rates in U/r0. eta is the initial growth rate (Eq. 15),
G(t) = max |exp(A t) d|/|d| the largest growth, K the Kreiss constant of the leading mode's block,
its growth taken out. Norms: "paper" is Eq. 8 (sum of squares of coefficients), "surface" the mean
square displacement over the membrane, "strain" the elastic energy with rigid motions counted by
their displacement (see `celltrain.stability.strain_norm`).
"""
    )
    found: dict[int, dict[str, Measures]] = {}
    base = None
    for degree in DEGREES:
        train = Train(diameter=6, packing=0.2, cells=1, degree=degree)
        base = steady(train, start=base, estimate_error=False)
        found[degree] = measures(base)
        page.log(f"degree {degree}")
    verdicts = []
    for name in COLORS:
        page.heading(f"Norm: {name}")
        rows = {degree: numbers(found[degree][name]) for degree in DEGREES}
        changes = np.abs(rows[DEGREES[-1]] / rows[DEGREES[-2]] - 1.0)
        page.table(
            ("M", "eta", *(f"G({time:g})" for time in TIMES), "K"),
            [(degree, *(f"{value:.4g}" for value in row)) for degree, row in rows.items()]
            + [("last change", *(f"{100.0 * change:.1f} %" for change in changes))],
        )
        verdicts.append((name, *(_yes(change) for change in changes)))
    page.heading("What has converged")
    page.text(
        f"""
Yes where the step from M = {DEGREES[-2]} to {DEGREES[-1]} changes a number by less than
{100.0 * CONVERGED:g} %.
"""
    )
    page.table(("norm", "eta", *(f"G({time:g})" for time in TIMES), "K"), verdicts)
    page.text(statement(found))
    draw(page, found)
    page.write()


def numbers(each: Measures) -> np.ndarray:
    """One row of a table."""
    return np.array([each.growth.numerical_abscissa, *each.at_times, each.kreiss])


def statement(found: dict[int, dict[str, Measures]]) -> str:
    """In words what the lowest degree leaves."""
    first, last = DEGREES[0], DEGREES[-1]
    rates, later = [], []
    for name in COLORS:
        change = numbers(found[first][name]) / numbers(found[last][name]) - 1.0
        rates.append(f"{100.0 * change[0]:+.0f} % ({name})")
        later.append(100.0 * np.abs(change[1:-1]).max())
    return (
        f"At M = {first} the initial growth rate eta is off by {', '.join(rates)} of its value at M"
        f" = {last}, but the growth G(t) at the times above by {max(later):.1f} % at most: finer"
        " disturbances rise faster at first, but get no further, as they are gone the sooner. By"
        " strain, fine disturbances are large to begin with."
    )


def draw(page: Page, found: dict[int, dict[str, Measures]]) -> None:
    """G(t) at the lowest and the highest degree, and eta against the degree."""
    figure = plain_figure(9.0, 3.8)
    left, right = figure.subplots(1, 2)
    first, last = DEGREES[0], DEGREES[-1]
    for name, color in COLORS.items():
        for degree, style in ((first, "--"), (last, "-")):
            growth = found[degree][name].growth
            left.loglog(
                growth.times[1:],
                growth.growth[1:],
                style,
                color=color,
                label=f"{name}, M = {degree}",
            )
        rates = [found[degree][name].growth.numerical_abscissa for degree in DEGREES]
        right.plot(DEGREES, np.array(rates) / rates[-1], "o-", color=color, label=name)
    left.set(xlabel="t, r0/U", ylabel="G(t)")
    left.set_yticks([1, 2, 4, 8], ["1", "2", "4", "8"])
    left.minorticks_off()
    left.set_title("Largest growth up to a time", fontsize=10)
    right.set(xlabel="degree M", xticks=DEGREES)
    right.set_title(f"Initial growth rate over its value at M = {last}", fontsize=10)
    for axes in (left, right):
        axes.legend(fontsize=8, frameon=False)
    page.figure(figure, "Largest growth up to a time, and initial growth rate, in three norms")


def _yes(change: float) -> str:
    return "yes" if change < CONVERGED else "no"
