"""The branch of steady trains in a tube of diameter 6, from packing 0.2 to 0.7."""

from dataclasses import dataclass

from page import Page, plain_figure

from celltrain import Base, Stability, Train, paper_units, stability, steady

PACKINGS = tuple(round(0.2 + 0.05 * step, 2) for step in range(11))
# The paper's statement P8: alpha below 1e-3 in its unit for these packings.
WINDOW = (0.4, 0.55)
MARGINAL = paper_units.rate_from_paper(1e-3)
# A trial implementation's numbers at packing 0.5: gap, U_c, eta (paper's norm), eta (orthonormal).
TRIAL = (0.940, 1.7418, 3.35, 2.52)


@dataclass(frozen=True)
class Statement:
    """What is expected, and whether it was found."""

    text: str
    found: str
    holds: bool


def branch(page: Page) -> list[Stability]:
    """All trains, each reached from the one before."""
    results: list[Stability] = []
    start: Base | None = None
    for packing in PACKINGS:
        train = Train(diameter=6, packing=packing, cells=8, degree=12)
        start = steady(train, start=start)
        result = stability(start)
        results.append(result)
        page.log(f"packing {packing:g}: alpha {result.spectral_abscissa:.2e} U/r0")
    return results


def study() -> None:
    page = Page("packing", "Packing from 0.2 to 0.7 at diameter 6")
    page.text(
        """
D = 6 r0, N = 8, viscosity ratio 1, default resolution (M = 12). The train at packing 0.2 is reached
from rest, every other one by continuation from the one before. alpha: largest growth rate, neutral
modes set aside, with its error estimated by two more degrees; m and j: azimuthal and wave number of
that mode, q = 2 pi j/N; Delta: least streamwise separation of membranes. Rates in U/r0; those that
the paper prints are ten times as large.
"""
    )
    results = branch(page)
    by_packing = {result.base.train.packing: result for result in results}
    page.heading("The branch")
    page.table(
        (
            "phi",
            "Delta, r0",
            "U_c, U",
            "alpha, U/r0",
            "error of it",
            "m",
            "j",
            "eta, U/r0",
            "residual, U",
        ),
        [_row(result) for result in results],
    )
    page.heading("Beside the paper's statements")
    page.table(
        ("expected", "found", "holds"),
        [
            (each.text, each.found, "yes" if each.holds else "no")
            for each in _statements(by_packing)
        ],
    )
    half = by_packing[0.5]
    gap, velocity, eta, plain = TRIAL
    page.heading("Beside a trial implementation, packing 0.5")
    page.table(
        ("", "found", "trial"),
        (
            ("Delta, r0", f"{half.base.gap:.4f}", gap),
            ("U_c, U", f"{half.base.cell_velocity:.4f}", velocity),
            ("alpha, U/r0", f"{half.spectral_abscissa:.1e}", "below 3e-5"),
            ("eta, paper's norm, U/r0", f"{half.numerical_abscissa:.3f}", eta),
            ("eta, orthonormal, U/r0", f"{half.numerical_abscissas['orthonormal']:.3f}", plain),
        ),
    )
    _figure(page, results)
    page.write()


def _row(result: Stability) -> tuple[object, ...]:
    base, leading = result.base, result.leading
    return (
        f"{base.train.packing:g}",
        f"{base.gap:.4f}",
        f"{base.cell_velocity:.5f}",
        f"{result.spectral_abscissa:.2e}",
        f"{result.error_estimate:.0e}",
        leading.azimuthal_number,
        leading.wave_number,
        f"{result.numerical_abscissa:.3f}",
        f"{base.residual:.0e}",
    )


def _statements(results: dict[float, Stability]) -> list[Statement]:
    sparse, dense = results[0.2], results[0.7]
    half = sparse.base.train.cells // 2
    inside = {
        phi: each.spectral_abscissa
        for phi, each in results.items()
        if WINDOW[0] <= phi <= WINDOW[1]
    }
    largest = max(inside.values())
    return [
        _order_of_magnitude("P6", sparse),
        Statement(
            "P9: at phi = 0.2 cells tilt, all alike (m = 1, q = 0)",
            _place(sparse),
            (sparse.leading.azimuthal_number, sparse.leading.wave_number) == (1, 0),
        ),
        _order_of_magnitude("P7", dense),
        Statement(
            f"P9: at phi = 0.7 a wave of two cells (m = 1, j = {half})",
            _place(dense),
            (dense.leading.azimuthal_number, dense.leading.wave_number) == (1, half),
        ),
        Statement(
            f"P8: alpha < 0.001 as printed, {MARGINAL:g} U/r0, at phi = {WINDOW[0]}...{WINDOW[1]}",
            ", ".join(f"{phi:g}: {alpha:.1e}" for phi, alpha in inside.items()),
            largest < MARGINAL,
        ),
    ]


def _order_of_magnitude(name: str, result: Stability) -> Statement:
    printed = paper_units.rate(result.spectral_abscissa)
    return Statement(
        f"{name}: at phi = {result.base.train.packing:g} alpha ~ 0.1 as printed (0.03 to 0.2)",
        f"{printed:.3f}",
        0.03 < printed < 0.2,
    )


def _place(result: Stability) -> str:
    return f"m = {result.leading.azimuthal_number}, j = {result.leading.wave_number}"


def _figure(page: Page, results: list[Stability]) -> None:
    figure = plain_figure()
    axes = figure.subplots()
    packings = [result.base.train.packing for result in results]
    rates = [1e3 * result.spectral_abscissa for result in results]
    errors = [1e3 * result.error_estimate for result in results]
    axes.axhline(0.0, color="0.6", linewidth=0.8)
    axes.errorbar(packings, rates, errors, fmt="o-", capsize=3)
    for result, rate in zip(results, rates, strict=True):
        label = f"{result.leading.azimuthal_number}, {result.leading.wave_number}"
        place = (result.base.train.packing, rate)
        axes.annotate(label, place, (6, 5), textcoords="offset points", fontsize=8)
    axes.set(xlabel=r"packing $\phi$", ylabel=r"$\alpha$, $10^{-3}\, U/r_0$")
    page.figure(figure, "Largest growth rate against packing, its error, and m, j of its mode")
