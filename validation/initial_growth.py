"""The initial growth rate eta over the degree, in every norm (P11, P12): does it converge?

Kept in docs/validation/data/initial-growth.nc; computed anew if the file is not there.
"""

import numpy as np
import xarray as xr
from degrees import LADDER
from page import FOLDER, Page, plain_figure

from celltrain import Train, steady
from celltrain.stability import NORMS, StrainNorm, normed_block
from celltrain.stability.linearise import linear_blocks
from celltrain.stability.neutral import neutral_space
from celltrain.stability.norms import Norm
from celltrain.steady.degree import remaining

FILE = FOLDER / "data" / "initial-growth.nc"
CELLS, MOST_AZIMUTHAL = 8, 8
CASES = ((6.0, 0.2), (6.0, 0.7), (10.0, 0.2), (10.0, 0.7))
#: What the paper draws for these four (Fig. 8b): m, and cells a wave.
PAPER = ("not 0; 2", "not 0; 4", "not 0; 2", "0; 4")
NAMES = (*(norm.name for norm in NORMS), "strain")
#: Least gain from one degree of the ladder to the next that is no convergence.
STILL_GROWS = 0.02


def compute(page: Page) -> xr.Dataset:
    """eta, m and j for each train, norm and degree."""
    phases = 2.0 * np.pi * np.arange(CELLS // 2 + 1) / CELLS
    numbers = range(MOST_AZIMUTHAL + 1)
    found = np.full((3, len(CASES), len(NAMES), len(LADDER)), np.nan)
    for row, (diameter, packing) in enumerate(CASES):
        base = None
        for column, degree in enumerate(LADDER):
            train = Train(diameter=diameter, packing=packing, cells=CELLS, degree=degree)
            base = steady(train, start=base, estimate_error=False)
            blocks = linear_blocks(base, phases, numbers)
            norms: tuple[Norm, ...] = (*NORMS, StrainNorm(train))
            for place, norm in enumerate(norms):
                grams = norm.grams(base.coefficients, numbers)
                rates = []
                for m in numbers:
                    for wave, block in enumerate(blocks[m]):
                        each = normed_block(block, grams[m], neutral_space(base, m, wave))
                        rates.append((each.numerical_abscissa, m, wave))
                found[:, row, place, column] = max(rates)
            page.log(f"D = {diameter:g}, packing {packing:g}, degree {degree}")
    dims = ("case", "norm", "degree")
    return xr.Dataset(
        {
            "eta": (dims, found[0], {"units": "U/r0", "long_name": "initial growth rate"}),
            "azimuthal_number": (dims, found[1]),
            "wave_number": (dims, found[2]),
        },
        coords={
            "norm": list(NAMES),
            "degree": list(LADDER),
            "diameter": ("case", [each[0] for each in CASES], {"units": "r0"}),
            "packing": ("case", [each[1] for each in CASES]),
        },
        attrs={
            "title": "initial growth rate over the degree, by norm",
            "comment": f"N = {CELLS}, viscosity ratio 1, azimuthal numbers 0 to {MOST_AZIMUTHAL},"
            " volumes kept",
        },
    )


def study() -> None:
    page = Page("initial_growth", "Initial growth rates over the degree (P11, P12)")
    data = page.kept(FILE, compute)
    page.text(
        f"""
eta, the largest growth rate at the first moment (Eq. 15) of disturbances that keep the cells'
volumes, and the azimuthal number m and wave number j (q = 2 pi j/{CELLS}) of that disturbance; N =
{CELLS}, viscosity ratio 1, at the corners of the paper's map; in U/r0 (the paper prints ten times
as much). The paper's norm is that of Eq. (8).
"""
    )
    headings = ("D", "packing", *(f"M = {each}" for each in LADDER), "left", "paper: m; cells")
    for norm in NAMES:
        page.heading(f"Norm: {norm}")
        page.table(headings, list(_rows(data.sel(norm=norm))))
    gains = data["eta"].isel(degree=-1) / data["eta"].isel(degree=-2) - 1.0
    first = data["eta"].sel(degree=LADDER[0]) / data["eta"].isel(degree=-1)
    page.heading("The law")
    changes = "; ".join(
        f"{100.0 * float(abs(gains.sel(norm=norm)).max()):.2g} % at most ({norm})" for norm in NAMES
    )
    lowest = ", ".join(
        f"{100.0 * float(first.sel(norm=norm).min()):.0f} to"
        f" {100.0 * float(first.sel(norm=norm).max()):.0f} % ({norm})"
        for norm in NAMES
    )
    law = "still grows" if float(abs(gains).max()) > STILL_GROWS else "converges"
    page.text(
        f"From M = {LADDER[-2]} to {LADDER[-1]} eta changes by {changes}: it {law}. M ="
        f" {LADDER[0]} has {lowest} of what M = {LADDER[-1]} has, and often another disturbance."
        f" In the paper's norm the last change is {_factors(data)} of that from M = 16 to 20."
    )
    _figure(page, data)
    page.write()


def _rows(at: xr.Dataset) -> list[tuple[str, ...]]:
    rows = []
    for row, ((diameter, packing), words) in enumerate(zip(CASES, PAPER, strict=True)):
        case = at.isel(case=row)
        cells = (_cell(case.isel(degree=column)) for column in range(len(LADDER)))
        left = f"{remaining(case['eta'].values.tolist()):.0e}"
        rows.append((f"{diameter:g}", f"{packing:g}", *cells, left, words))
    return rows


def _cell(at: xr.Dataset) -> str:
    m, wave = float(at["azimuthal_number"]), float(at["wave_number"])
    return f"{float(at['eta']):.3f} ({m:.0f}, {wave:.0f})"


def _factors(data: xr.Dataset) -> str:
    changes = np.abs(np.diff(data["eta"].sel(norm="paper").values, axis=-1))
    return ", ".join(f"{each:.2g}" for each in changes[:, -1] / changes[:, 1])


def _figure(page: Page, data: xr.Dataset) -> None:
    figure = plain_figure(8.6, 3.6)
    panels = figure.subplots(1, len(NAMES))
    for axes, norm in zip(panels, NAMES, strict=True):
        for row, (diameter, packing) in enumerate(CASES):
            values = data["eta"].sel(norm=norm).isel(case=row)
            axes.plot(LADDER, values, ".-", label=rf"$D$ = {diameter:g}, $\phi$ = {packing:g}")
        axes.set(xlabel="$M$", ylim=(0.0, None))
        axes.set_title(norm, fontsize=9)
    panels[0].set_ylabel(r"$\eta$ ($U/r_0$)")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=8, frameon=False)
    page.figure(figure, "Initial growth rate over the degree, by norm")
