"""What destabilises a train: strain energy, spectra, neighbours, streamlines (Figs. 7, 10, 20)."""

import math
from typing import Any

import numpy as np
from degrees import FINE, PAPER
from page import FOLDER, Page, plain_figure

from celltrain import Base, Stability, Train, stability, steady
from celltrain.diagnostics import (
    deformation_spectrum,
    meridional_flow,
    perturbation_energy,
    recirculation,
)
from celltrain.pictures import draw_growth_without_neighbours, draw_streamlines
from celltrain.stability import growth_without_neighbours

CELLS = 8
# W_alpha, and W_eta as a sum and by shear, dilatation and bending, of Table I, by (D/r0, packing).
TABLE = {
    (6, 0.2): (1.13e-2, 2.48, 0.43, 2.01, 0.04),
    (6, 0.7): (4.29e-3, 2.42, 0.74, 1.52, 0.16),
    (10, 0.2): (9.16e-3, 1.95, 0.59, 1.31, 0.05),
    (10, 0.7): (3.95e-3, 4.91, 0.43, 4.25, 0.23),
}
# From mean energies in mu U r0^2 to the sum over the cells in mu U* r0^2, U* = U/10.
TO_TABLE = 10.0 * CELLS
STREAMLINES = (0.3, 0.5, 0.7)
# Degrees of the disturbances from here on count as short waves: half of the paper's M.
SHORT_WAVES = PAPER // 2


Results = dict[tuple[int, float], Stability]


def trains(degree: int) -> Results:
    """The four trains of Table I at a degree."""
    found = {}
    for diameter in (6, 10):
        base = None
        for packing in (0.2, 0.5, 0.7):
            train = Train(diameter=diameter, packing=packing, cells=CELLS, degree=degree)
            base = steady(train, start=base, estimate_error=False)
            if (diameter, packing) in TABLE:
                found[diameter, packing] = stability(base, estimate_error=False)
    return found


def study() -> None:
    page = Page("mechanisms", "Mechanisms")
    page.text(
        f"""
N = {CELLS}, viscosity ratio 1, M = {FINE}, and beside it the paper's resolution, M = {PAPER};
v_alpha is the fastest growing mode, v_eta the disturbance that grows fastest at first in the norm
of Eq. (8). Rates in U/r0; those that the paper prints are ten times as large.
"""
    )
    results = {}
    for degree in (FINE, PAPER):
        results[degree] = trains(degree)
        page.log(f"trains, degree {degree}")
    energies(page, results)
    spectra(page, results)
    neighbours(page, results)
    streamlines(page)
    page.write()


def energies(page: Page, results: dict[int, Results]) -> None:
    """Table I."""
    page.heading("Strain energy of disturbances (Table I)")
    page.text(
        """
W of Eq. (24) at eps = 1e-3, summed over the cells, in mu U* r0^2 with U* = U/10: the unit in which
the two tables are nearest (geometric mean of the eight ratios below; the average over the cells
would be eight times smaller, mu U r0^2 ten times). v_alpha of a disturbance that is the same in all
cells has an energy of first order in eps, whose sign is arbitrary; here it is not (m > 0 or q > 0).
"""
    )
    rows: list[tuple[object, ...]] = []
    ratios: dict[int, list[float]] = {degree: [] for degree in results}
    parts: dict[int, list[tuple[np.ndarray, np.ndarray]]] = {degree: [] for degree in results}
    for (diameter, packing), expected in TABLE.items():
        rows.append((diameter, packing, "paper", *(f"{each:.3g}" for each in expected)))
        for degree, found in reversed(results.items()):
            result = found[diameter, packing]
            leading = TO_TABLE * perturbation_energy(result.base, result.shape(result.leading))
            abrupt = TO_TABLE * perturbation_energy(result.base, result.transient_shape())
            numbers = (leading.sum(), abrupt.sum(), *abrupt)
            ratios[degree] += [numbers[0] / expected[0], numbers[1] / expected[1]]
            parts[degree].append((leading, abrupt))
            rows.append((diameter, packing, f"M = {degree}", *(f"{each:.3g}" for each in numbers)))
    page.table(("D/r0", "packing", "", "W_alpha", "W_eta", "shear", "dilatation", "bending"), rows)
    words = "; ".join(
        f"M = {degree}: {math.exp(float(np.mean(np.log(np.abs(each))))):.2f} in the geometric mean,"
        f" within a factor of {math.exp(float(np.std(np.log(np.abs(each))))):.1f} (one standard"
        " deviation)"
        for degree, each in reversed(ratios.items())
    )
    page.text(
        f"""
Ratio of ours to the paper's for the sums: {words}. W_eta belongs to the disturbance that
grows fastest at first, of short waves that M = {PAPER} cuts off; at M = {FINE} eta is known to some
per cent (see [convergence](convergence.md)). So the paper's W_eta cannot be expected to agree.
"""
    )
    statements = (
        (
            "v_alpha is nearly free of strain beside v_eta",
            lambda leading, abrupt: leading.sum() < 0.05 * abrupt.sum(),
        ),
        (
            "of W_eta dilatation is the largest part, bending the smallest",
            lambda _, abrupt: abrupt[1] > abrupt[0] > abrupt[2],
        ),
    )
    page.table(
        ("the paper says", *(f"holds, M = {degree}" for degree in results)),
        [
            (words, *(_yes(all(check(*pair) for pair in parts[degree])) for degree in results))
            for words, check in statements
        ],
    )


def spectra(page: Page, every: dict[int, Results]) -> None:
    """Fig. 10."""
    page.heading("Spectra of the disturbances (Fig. 10)")
    rows = []
    figure = plain_figure(7.0, 4.4)
    axes = figure.subplots()
    colors = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")
    for degree, results in every.items():
        for color, ((diameter, packing), result) in zip(colors, results.items(), strict=True):
            shares = []
            for shape, style in (
                (result.shape(result.leading), "o-"),
                (result.transient_shape(), "s--"),
            ):
                spectrum = deformation_spectrum(shape)
                spectrum = spectrum / spectrum.sum()
                shares.append(spectrum[SHORT_WAVES:].sum())
                if degree == FINE:
                    axes.semilogy(spectrum, style, color=color, markersize=3)
            if degree == FINE:
                axes.plot([], [], color=color, label=f"D = {diameter}, packing {packing:g}")
            rows.append(
                (
                    diameter,
                    packing,
                    degree,
                    *(f"{share:.1e}" for share in shares),
                    _yes(shares[0] < shares[1]),
                )
            )
    rows.sort(key=lambda row: (row[0], row[1], -int(row[2])))
    page.table(
        (
            "D/r0",
            "packing",
            "M",
            f"share of n >= {SHORT_WAVES} in v_alpha",
            "in v_eta",
            "v_alpha decays faster",
        ),
        rows,
    )
    axes.set(xlabel="degree $n$", ylabel="$E_n$ (Eq. 16), sum 1")
    axes.legend(fontsize=8, frameon=False)
    page.figure(figure, f"Spectra of v_alpha (full lines) and v_eta (dashed), M = {FINE}")


def neighbours(page: Page, every: dict[int, Results]) -> None:
    """Fig. 20."""
    page.heading("Without near neighbours (Eq. 22, Fig. 20)")
    curves = {
        degree: {
            key: [growth_without_neighbours(result, removed) for removed in range(CELLS // 2 + 1)]
            for key, result in results.items()
        }
        for degree, results in every.items()
    }
    page.log("without neighbours")
    page.table(
        ("D/r0", "packing", "M", *(f"{removed} removed" for removed in range(CELLS // 2 + 1))),
        [
            (
                *key,
                degree,
                *(
                    f"{each.spectral_abscissa:.2e} (m = {each.azimuthal_number})"
                    for each in curves[degree][key]
                ),
            )
            for key in curves[FINE]
            for degree in every
        ],
    )
    rows = []
    for key in curves[FINE]:
        factors = []
        for degree in every:
            first, second = (each.spectral_abscissa for each in curves[degree][key][:2])
            factors.append("stable" if second <= 0.0 else f"{first / second:.3g}")
        stated = "up to 1000 over the paper's range of v and Ca" if key[1] == 0.7 else "1.4"
        rows.append((*key, *factors, stated))
    page.table(
        (
            "D/r0",
            "packing",
            *(f"alpha falls by the first neighbours' removal, M = {degree}" for degree in every),
            "paper",
        ),
        rows,
    )
    path = FOLDER / "mechanisms-neighbours.png"
    draw_growth_without_neighbours(
        {f"D = {d}, packing {phi:g}": found for (d, phi), found in curves[FINE].items()}, path
    )
    page.parts.append(f"![Growth without near neighbours, M = {FINE}]({path.name})")


def streamlines(page: Page) -> None:
    """Fig. 7."""
    page.heading("Streamlines in the frame of the cells (Fig. 7)")
    rows: list[tuple[Any, ...]] = []
    starts: dict[int, Base | None] = {FINE: None, PAPER: None}
    for packing in STREAMLINES:
        for degree, start in starts.items():
            train = Train(diameter=6, packing=packing, cells=CELLS, degree=degree)
            base = steady(train, start=start, estimate_error=False)
            starts[degree] = base
            flow = meridional_flow(base)
            found = recirculation(base, flow)
            page.log(f"streamlines at packing {packing:g}, degree {degree}")
            if degree == FINE:
                path = FOLDER / f"mechanisms-streamlines-{round(10 * packing):02d}.png"
                draw_streamlines(base, flow, path)
                page.parts.append(f"![Streamlines at packing {packing:g}]({path.name})")
            rows.append(
                (
                    packing,
                    degree,
                    f"{found.axis_velocity:+.2e}",
                    len(found.stagnation_points),
                    f"{found.strength:.1e}",
                    "none"
                    if math.isnan(found.centre[0])
                    else f"{found.centre[0]:.2f}, {found.centre[1]:+.2f}",
                )
            )
    page.table(
        (
            "packing",
            "M",
            "velocity on the axis between cells, U",
            "points of rest there",
            "turning fluid over passing",
            "its centre (r, z from the middle)",
        ),
        rows,
    )
    page.text(
        """
The paper: for packings up to 0.4 the regions that turn back join on the centre line; between 0.4
and 0.55 the fluid nearly rests there; from 0.6 on it turns in small regions beside the cells only.
Turning fluid that is less than 1e-4 of what passes is not told from none. So at packing 0.7 the
small regions may be there, but are not seen.
"""
    )


def _yes(holds: bool) -> str:
    return "yes" if holds else "NO"
