"""Growth without near neighbours: Fig. 20, and the paper's statement about it (Sec. V F)."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from celltrain.paper.curves import side_by_side
from celltrain.paper.finding import DENSE, SPARSE, Finding, finding, in_paper_units
from celltrain.paper.resolutions import LABELS, PAPER, Resolutions, Style, present
from celltrain.paper.trains import CELLS, dataset
from celltrain.parameters import Train, paper_units
from celltrain.stability import growth_without_neighbours, stability
from celltrain.steady import Base

#: What is varied about the usual cell: Ca as the paper counts it, and the reduced volume.
VARIED = (
    ("Ca = 0.66, v = 0.64", 0.66, None),
    ("Ca = 2, v = 0.64", 2.0, None),
    ("Ca = 4, v = 0.64", 4.0, None),
    ("Ca = 0.66, v = 0.5", 0.66, 0.5),
    ("Ca = 0.66, v = 0.8", 0.66, 0.8),
)
DIAMETER, PACKINGS = 8.0, (SPARSE, DENSE)
#: Azimuthal numbers that are looked at: in strong flow those up to 8 lead.
NUMBERS = range(9)
REMOVED = tuple(range(CELLS // 2 + 1))
#: The paper's factors by which alpha falls, and what "about" may mean.
SPARSE_FALL, LEEWAY, MANY = 1.4, (1.2, 1.7), 100.0


def compute(degree: int | None) -> xr.Dataset:
    """alpha without the nearest neighbours (Eq. 22), D = 8."""
    found = np.full((3, len(PACKINGS), len(VARIED), len(REMOVED)), np.nan)
    errors = np.full((len(PACKINGS), len(VARIED)), np.nan)
    for row, packing in enumerate(PACKINGS):
        start: Base | None = None
        for column, (_, capillary, volume) in enumerate(VARIED):
            train = Train(diameter=DIAMETER, packing=packing, cells=CELLS, degree=degree)
            train = train.changed(
                capillary_number=paper_units.capillary_number_from_paper(capillary)
            )
            if volume is not None:
                train = train.changed(reduced_volume=volume)
            result = stability(train, start=start, azimuthal_numbers=NUMBERS)
            start = result.base if volume is None else None
            errors[row, column] = result.error_estimate
            for place, removed in enumerate(REMOVED):
                each = growth_without_neighbours(result, removed)
                found[:, row, column, place] = (
                    each.spectral_abscissa,
                    each.azimuthal_number,
                    each.wave_number,
                )
    dims = ("packing", "cell", "removed")
    return dataset(
        {
            "alpha": (dims, found[0], "U/r0", "largest growth rate without neighbours (Eq. 22)"),
            "azimuthal_number": (dims, found[1], "1", "m of its mode"),
            "wave_number": (dims, found[2], "1", "j of its mode"),
            "error_estimate": (("packing", "cell"), errors, "U/r0", "error with all neighbours"),
        },
        {
            "packing": list(PACKINGS),
            "cell": [name for name, *_ in VARIED],
            "removed": list(REMOVED),
        },
        "largest growth rate without the nearest neighbours, D = 8",
    )


def draw(data: Resolutions) -> Figure:
    """Fig. 20: alpha over the neighbours removed on each side, in the paper's unit."""
    figure, panels = side_by_side(2)
    for axes, packing in zip(panels, PACKINGS, strict=True):
        for name, each in present(data):
            for place, cell in enumerate(each["cell"].values):
                alpha = in_paper_units(each["alpha"].sel(packing=packing, cell=cell))
                lonely = name == PAPER and len(data) > 1
                style: Style = {"ls": "none"} if lonely else {}
                label = None if lonely else str(cell)
                marker: Style = {"marker": "o", "mfc": "none"} if name == PAPER else {}
                axes.plot(REMOVED, alpha, color=f"C{place}", ms=5, label=label, **style, **marker)
        axes.axhline(0.0, color="0.6", linewidth=0.8, zorder=0)
        axes.set_yscale("symlog", linthresh=1e-2)
        axes.set_xticks(REMOVED)
        axes.set(xlabel="neighbours removed on each side", ylabel=r"$\tilde\alpha\, r_0/U^*$")
        axes.set_title(f"{axes.get_title()}  $\\phi$ = {packing:g}", fontsize=10)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=8, frameon=False)
    if len(data) > 1:
        figure.suptitle(f"lines: {LABELS['converged']}; circles: {LABELS[PAPER]}", fontsize=8)
    return figure


def findings(data: xr.Dataset) -> list[Finding]:
    """The statement about near neighbours (Fig. 20)."""
    alpha = in_paper_units(data["alpha"])
    sparse, dense = (alpha.sel(packing=packing) for packing in PACKINGS)
    usual = sparse.isel(cell=0)
    fall = float(usual[0] / usual[1]) if usual[1] > 0.0 else np.inf
    listed = "; ".join(
        f"{name}: {float(row[0]):.3f} to {float(row[1]):.3f}"
        for name, row in zip(dense["cell"].values, dense, strict=True)
    )
    lower = dense.isel(removed=1) < dense.isel(removed=0)
    falls = (dense.isel(removed=0) / dense.isel(removed=1)).where(dense.isel(removed=1) > 0.0)
    most = float(falls.max()) if bool(falls.notnull().any()) else np.inf
    return [
        finding(
            "P29",
            "packing 0.7: alpha falls when the nearest neighbours are removed",
            listed,
            bool(lower.all()),
            dense,
        ),
        finding(
            "P29",
            "packing 0.7: by up to a factor of 1000, most for large Ca and v",
            "by a factor of up to "
            + (f"{most:.3g}" if np.isfinite(most) else "any")
            + f" where it stays positive, in {int(falls.notnull().sum())} of {falls.size}; the"
            " others become stable",
            most > MANY,
            dense,
        ),
        finding(
            "P29",
            f"packing 0.2: by a factor of {SPARSE_FALL:g}",
            f"{fall:.2f}: {float(usual[0]):.3f} to {float(usual[1]):.3f}",
            LEEWAY[0] < fall < LEEWAY[1],
            usual,
        ),
    ]
