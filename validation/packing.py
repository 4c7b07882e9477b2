"""The branch of steady trains in a tube of diameter 6, from packing 0.2 to 0.7."""

from dataclasses import dataclass

from page import Page, plain_figure

from celltrain import Base, Stability, Train, paper_units, stability

PACKINGS = tuple(round(0.2 + 0.05 * step, 2) for step in range(11))
# The paper's statement P8: alpha below 1e-3 in its unit for these packings.
WINDOW = (0.4, 0.55)
MARGINAL = paper_units.rate_from_paper(1e-3)
# The paper's degree.
PAPER = 12
# Azimuthal numbers that are looked at there; the converged trains have all.
NUMBERS = range(4)
# A trial implementation's numbers at packing 0.5, M = 12: gap, U_c, eta (paper's norm), eta
# (orthonormal).
TRIAL = (0.940, 1.7418, 3.35, 2.52)


@dataclass(frozen=True)
class Statement:
    """What is expected, and whether it was found."""

    text: str
    found: str
    holds: bool


def branch(page: Page) -> list[tuple[Stability, Stability]]:
    """All trains, each reached from the one before: at the default accuracy and at `PAPER`."""
    results: list[tuple[Stability, Stability]] = []
    start: Base | None = None
    for packing in PACKINGS:
        train = Train(diameter=6, packing=packing, cells=8)
        coarse = stability(train.changed(degree=PAPER), start=start, azimuthal_numbers=NUMBERS)
        start = coarse.base
        fine = stability(train, start=start)
        results.append((fine, coarse))
        page.log(
            f"packing {packing:g}: M = {fine.base.train.degree}, alpha"
            f" {fine.spectral_abscissa:.2e} U/r0"
        )
    return results


def study() -> None:
    page = Page("packing", "Packing from 0.2 to 0.7 at diameter 6")
    page.text(
        f"""
D = 6 r0, N = 8, viscosity ratio 1, at the default accuracy (alpha to 1 % or 1e-4 U/r0): M is the
degree that this took. Beside it the paper's resolution, M = {PAPER}. The train at packing 0.2 is
reached from rest, every other one by continuation from the one before. alpha: largest growth rate,
neutral modes set aside, with the error that is reported; m and j: azimuthal and wave number of that
mode, q = 2 pi j/N; Delta: least streamwise separation of membranes; eta: numerical abscissa in the
paper's norm, which needs a higher degree than alpha does (see [convergence](convergence.md)). Rates
in U/r0; those that the paper prints are ten times as large.
"""
    )
    results = branch(page)
    page.heading("The branch")
    page.table(
        (
            "phi",
            "M",
            "Delta, r0",
            "U_c, U",
            "alpha, U/r0",
            "error of it",
            "m, j",
            "eta, U/r0",
            "residual, U",
        ),
        [_row(fine) for fine, _ in results],
    )
    page.heading(f"The same at M = {PAPER}")
    page.table(
        (
            "phi",
            "Delta, r0",
            "U_c, U",
            "alpha, U/r0",
            "error of it",
            "true error",
            "m, j",
            "eta, U/r0",
        ),
        [_coarse_row(fine, coarse) for fine, coarse in results],
    )
    covered = sum(
        abs(coarse.spectral_abscissa - fine.spectral_abscissa)
        <= coarse.error_estimate + fine.error_estimate
        for fine, coarse in results
    )
    page.text(
        f"""
True error: distance from the growth rate above, which the two errors together cover in {covered}
of {len(results)} trains.
"""
    )
    page.heading("Beside the paper's statements")
    statements = [
        _statements({pair[which].base.train.packing: pair[which] for pair in results})
        for which in (0, 1)
    ]
    page.table(
        ("expected", "found", "holds", f"found, M = {PAPER}", "holds"),
        [
            (fine.text, fine.found, _yes(fine.holds), coarse.found, _yes(coarse.holds))
            for fine, coarse in zip(*statements, strict=True)
        ],
    )
    by_packing = {fine.base.train.packing: (fine, coarse) for fine, coarse in results}
    at_edge, inside = by_packing[WINDOW[0]], by_packing[0.45][0]
    page.text(
        f"""
The difference is at packing {WINDOW[0]:g}: alpha is {at_edge[0].spectral_abscissa:+.1e}, and
{at_edge[1].spectral_abscissa:+.1e} at M = {PAPER}, with an error of
{at_edge[1].error_estimate:.0e}. So the trains that do not grow begin between packing
{WINDOW[0]:g} and 0.45, where alpha is {inside.spectral_abscissa:+.1e}.
"""
    )
    half = next(coarse for _, coarse in results if coarse.base.train.packing == 0.5)
    gap, velocity, eta, plain = TRIAL
    page.heading(f"Beside a trial implementation, packing 0.5, M = {PAPER}")
    page.table(
        ("", "found", "expected"),
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


def _yes(holds: bool) -> str:
    return "yes" if holds else "no"


def _row(result: Stability) -> tuple[object, ...]:
    base = result.base
    return (
        f"{base.train.packing:g}",
        base.train.degree,
        f"{base.gap:.4f}",
        f"{base.cell_velocity:.5f}",
        f"{result.spectral_abscissa:.3e}",
        f"{result.error_estimate:.0e}",
        f"{result.leading.azimuthal_number}, {result.leading.wave_number}",
        f"{result.numerical_abscissa:.3f}",
        f"{base.residual:.0e}",
    )


def _coarse_row(fine: Stability, coarse: Stability) -> tuple[object, ...]:
    base = coarse.base
    return (
        f"{base.train.packing:g}",
        f"{base.gap:.4f}",
        f"{base.cell_velocity:.5f}",
        f"{coarse.spectral_abscissa:.2e}",
        f"{coarse.error_estimate:.0e}",
        f"{abs(coarse.spectral_abscissa - fine.spectral_abscissa):.0e}",
        f"{coarse.leading.azimuthal_number}, {coarse.leading.wave_number}",
        f"{coarse.numerical_abscissa:.3f}",
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


def _figure(page: Page, results: list[tuple[Stability, Stability]]) -> None:
    figure = plain_figure(6.8, 4.2)
    axes = figure.subplots()
    axes.axhline(0.0, color="0.6", linewidth=0.8)
    packings = [fine.base.train.packing for fine, _ in results]
    for which, style, color, label in (
        (1, "s--", "#E69F00", f"M = {PAPER}"),
        (0, "o-", "#0072B2", "default accuracy"),
    ):
        rates = [1e3 * pair[which].spectral_abscissa for pair in results]
        errors = [1e3 * pair[which].error_estimate for pair in results]
        axes.errorbar(
            packings, rates, errors, fmt=style, color=color, capsize=3, markersize=4, label=label
        )
    for fine, _ in results:
        label = f"{fine.leading.azimuthal_number}, {fine.leading.wave_number}"
        place = (fine.base.train.packing, 1e3 * fine.spectral_abscissa)
        # Below the line where it rises.
        offset = (4, -13) if fine.base.train.packing > 0.5 else (7, 6)
        axes.annotate(label, place, offset, textcoords="offset points", fontsize=8)
    axes.set(xlabel=r"packing $\phi$", ylabel=r"$\alpha$, $10^{-3}\, U/r_0$")
    axes.set_xlim(right=0.73)
    axes.legend(frameon=False)
    page.figure(
        figure,
        "Largest growth rate against packing, with its error, and m, j of its mode at the default"
        " accuracy",
    )
