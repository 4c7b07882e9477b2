"""Growth at first, by the linear theory: Figs. 4 and 9, and the paper's statements about them."""

import numpy as np
import xarray as xr
from jaxtyping import Float
from matplotlib.figure import Figure

from celltrain.evolution import linear_prediction
from celltrain.harmonics import azimuthal_basis
from celltrain.paper.curves import side_by_side
from celltrain.paper.finding import Finding, finding
from celltrain.paper.resolutions import LABELS, PAPER, Resolutions, best, present
from celltrain.paper.trains import CELLS, analysed, dataset
from celltrain.parameters import paper_units
from celltrain.stability import PaperNorm, Stability, normed_blocks
from celltrain.stability.neutral import neutral_space
from celltrain.stability.transient import propagator_norm

#: r0/U: from the first moments to well beyond the transients.
TIMES = np.concatenate([[0.0], np.geomspace(1e-2, 1e3, 101)])
#: Diameters within which the paper has a tenfold growth, and what may be called that.
EARLY, TENFOLD = 0.4, (5.0, 20.0)
#: When v_eta falls below v_alpha in the paper (its unit of time), within a factor.
CROSSING, FACTOR = 0.2, 2.0
#: Cells of the trains whose eta is compared, and by how much it may differ.
LENGTHS, LENGTH_LEEWAY = (4, 8, 16), 0.05
CASES = {
    "fig4": (("N = 2, packing 0.2, viscosity ratio 5", 2, 0.2, 5.0),),
    "fig9": (
        ("D = 10, packing 0.2", CELLS, 0.2, 1.0),
        ("D = 10, packing 0.7", CELLS, 0.7, 1.0),
    ),
}


def small(degree: int | None) -> xr.Dataset:
    """The numbers of Fig. 4."""
    return _compute("fig4", degree)


def large(degree: int | None) -> xr.Dataset:
    """The numbers of Fig. 9, and eta of shorter and longer trains."""
    data = _compute("fig9", degree)
    rates = np.array(
        [
            [
                analysed(degree, cells=cells, diameter=10.0, packing=packing).numerical_abscissa
                for cells in LENGTHS
            ]
            for _, _, packing, _ in CASES["fig9"]
        ]
    )
    notes = {"units": "U/r0", "long_name": "initial growth rate by the number of cells"}
    return data.assign(eta_of_cells=(("case", "cells"), rates, notes)).assign_coords(
        cells=list(LENGTHS)
    )


def kept_volume(
    start: Stability, disturbance: Float[np.ndarray, "cell 3 coefficient"]
) -> Float[np.ndarray, "cell 3 coefficient"]:
    """A disturbance less what changes the cells' volumes, as simulations begin with it."""
    members = neutral_space(start.base, 0, 1).volume
    assert members is not None
    basis = azimuthal_basis(start.base.train.degree, 0)
    gradient = np.tensordot(members, basis, axes=1)
    share = np.tensordot(disturbance, gradient, axes=2) / np.sum(gradient**2)
    return np.asarray(disturbance - share[:, None, None] * gradient)


def _compute(figure: str, degree: int | None) -> xr.Dataset:
    cases = CASES[figure]
    sizes = np.full((len(cases), 2, len(TIMES)), np.nan)
    numbers = np.full((5, len(cases)), np.nan)
    for row, (_, cells, packing, ratio) in enumerate(cases):
        start = analysed(degree, cells=cells, diameter=10.0, packing=packing, viscosity_ratio=ratio)
        for column, shapes in enumerate((start.transient_shape(), start.shape(start.leading))):
            found = linear_prediction(start, kept_volume(start, shapes)).sizes(TIMES)[0]
            sizes[row, column] = found / found[0]
        way = start.base.cell_velocity / start.base.train.tube.diameter
        early = max(
            float(propagator_norm(block.matrix, np.array([EARLY / way]))[0])
            for block in normed_blocks(start, PaperNorm()).values()
        )
        numbers[:, row] = (
            start.spectral_abscissa,
            start.error_estimate,
            start.numerical_abscissa,
            early,
            way,
        )
    names = ("spectral_abscissa", "error_estimate", "numerical_abscissa", "early", "way")
    words = (
        "largest growth rate",
        "its error",
        "initial growth rate",
        f"largest growth of any disturbance by {EARLY:g} D",
        "diameters that cells go in a unit of time",
    )
    units = ("U/r0", "U/r0", "U/r0", "1", "U/r0")
    return dataset(
        {
            "size": (
                ("case", "disturbance", "time"),
                sizes,
                "1",
                "eps over its first, linear theory",
            )
        }
        | {
            name: (("case",), row, unit, long)
            for name, row, unit, long in zip(names, numbers, units, words, strict=True)
        },
        {
            "case": [name for name, *_ in cases],
            "disturbance": ["v_eta", "v_alpha"],
            "time": ("time", TIMES, {"units": "r0/U"}),
        },
        "growth of the leading mode and of what grows fastest at first",
    )


def draw_small(data: Resolutions) -> Figure:
    """Fig. 4 by the linear theory: v_eta and v_alpha over time, in the paper's units."""
    return _draw(data, 1e-3)


def draw_large(data: Resolutions) -> Figure:
    """Fig. 9 by the linear theory, in the paper's units."""
    return _draw(data, 0.1)


def _draw(data: Resolutions, amplitude: float) -> Figure:
    cases = [str(each) for each in best(data)["case"].values]
    figure, panels = side_by_side(len(cases))
    for axes, case in zip(panels, cases, strict=True):
        for name, each in present(data):
            at = each.sel(case=case)
            time = paper_units.time(at["time"].values[1:])
            for label, color in (("v_eta", "C1"), ("v_alpha", "C0")):
                size = amplitude * at["size"].sel(disturbance=label).values[1:]
                words = rf"$v_\{label[2:]}$, {LABELS[name]}"
                if name == PAPER:
                    axes.plot(time[::5], size[::5], "o", color=color, mfc="none", ms=4, label=words)
                else:
                    axes.plot(time, size, color=color, label=words)
            if name == present(data)[0][0]:
                powers = float(at["numerical_abscissa"]) * at["time"].values[1:]
                early = powers < 5.0
                axes.plot(
                    time[early],
                    amplitude * np.exp(powers[early]),
                    "k:",
                    linewidth=0.8,
                    label=r"$\exp\,\eta t$",
                )
        axes.set(xscale="log", yscale="log", ylim=(0.1 * amplitude, 30.0 * amplitude))
        axes.set(xlabel=r"$t\, U^*/r_0$", ylabel=r"$\varepsilon/r_0$", xlim=(1e-3, 1e2))
        axes.set_title(f"{axes.get_title()}  {case}", fontsize=9)
    panels[0].legend(fontsize=7, frameon=False, loc="upper left")
    return figure


def small_findings(data: xr.Dataset) -> list[Finding]:
    """The statement about Fig. 4 that the linear theory tells."""
    sizes = data["size"].isel(case=0)
    crossing = paper_units.time(_crossing(sizes))
    return [
        finding(
            "P5",
            f"v_eta is below v_alpha from t = {CROSSING:g} on, within a factor of two",
            f"from {crossing:.2g} on",
            CROSSING / FACTOR <= crossing <= CROSSING * FACTOR,
            [crossing],
        )
    ]


def large_findings(data: xr.Dataset) -> list[Finding]:
    """The statements about what grows at first that the linear theory tells (Sec. V B 2)."""
    rates = data["eta_of_cells"]
    spread = float((rates.max("cells") / rates.min("cells")).max()) - 1.0
    early = data["early"].values
    back = [_back(data, row) for row in range(data.sizes["case"])]
    return [
        finding(
            "P13",
            "eta does not depend on the length of the train",
            f"N = 4, 8, 16: within {spread:.1%}",
            spread < LENGTH_LEEWAY,
            rates,
        ),
        finding(
            "P13",
            f"eps has grown about tenfold when the cells have gone {EARLY:g} D",
            "at most by " + ", ".join(f"{each:.2f}" for each in early) + ", of any disturbance",
            bool(((early > TENFOLD[0]) & (early < TENFOLD[1])).all()),
            early,
        ),
        finding(
            "P13",
            "v_eta is below its first size again when they have gone one D",
            "at " + ", ".join(f"{each:.2f}" for each in back) + " D",
            max(back) < 1.0,
            back,
        ),
    ]


def _crossing(sizes: xr.DataArray) -> float:
    """From when on v_eta stays below v_alpha, r0/U; nan if it does not."""
    above = (sizes.sel(disturbance="v_eta") > sizes.sel(disturbance="v_alpha")).values
    last = int(np.flatnonzero(above)[-1]) if above.any() else 0
    return float("nan") if above[-1] else float(sizes["time"][last + 1])


def _back(data: xr.Dataset, row: int) -> float:
    """Diameters that the cells have gone when v_eta is below its first size; nan if never."""
    size = data["size"].isel(case=row).sel(disturbance="v_eta").values
    peak = int(np.argmax(size[data["time"].values < 10.0]))
    smaller = np.flatnonzero(size[peak:] < 1.0)
    if not smaller.size:
        return float("nan")
    return float(data["way"][row] * data["time"][peak + smaller[0]])
