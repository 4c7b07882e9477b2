"""The spectrum of two cells with a viscosity ratio of 5: Fig. 3, and the statement about it."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from celltrain.paper.curves import side_by_side
from celltrain.paper.finding import Finding, finding, in_paper_units, number
from celltrain.paper.resolutions import LABELS, PAPER, Resolutions, Style, present
from celltrain.paper.trains import analysed, dataset

#: How many eigenvalues the paper has with a positive real part.
POSITIVE = 3
#: "Most": this share of the modes decays faster than this many times the largest growth rate.
MOST, FAR = 0.9, 10.0
#: Limits of the two pictures, in the paper's unit: the whole, and what is near zero.
WHOLE, NEAR = (-120.0, 5.0), (-0.6, 0.25)
#: Least half height of the latter: frequencies that are zero to rounding are drawn as zero.
LEAST_HEIGHT = 0.1


def compute(degree: int | None) -> xr.Dataset:
    """All modes of the train that are not neutral, by falling growth rate."""
    result = analysed(
        degree, numbers=None, cells=2, diameter=10.0, packing=0.2, viscosity_ratio=5.0
    )
    modes = [mode for mode in result.modes if not mode.neutral]
    dims = ("mode",)
    return dataset(
        {
            "growth_rate": (dims, [each.growth_rate for each in modes], "U/r0", "growth rate"),
            "frequency": (dims, [each.frequency for each in modes], "U/r0", "frequency"),
            "azimuthal_number": (dims, [each.azimuthal_number for each in modes], "1", "m"),
            "wave_number": (dims, [each.wave_number for each in modes], "1", "j of q = pi j"),
            "error_estimate": ((), result.error_estimate, "U/r0", "error of the largest rate"),
            "taken_degree": ((), result.base.train.degree, "1", "degree"),
        },
        {},
        "modes of two cells, D = 10, packing 0.2, viscosity ratio 5",
    )


def draw(data: Resolutions) -> Figure:
    """Fig. 3: the eigenvalues at two scales, in the paper's unit."""
    figure, panels = side_by_side(2)
    for axes, limits in zip(panels, (WHOLE, NEAR), strict=True):
        for name, each in present(data):
            real, imaginary = (
                in_paper_units(each[part]).values for part in ("growth_rate", "frequency")
            )
            style: Style = {"mfc": "none", "ms": 6} if name == PAPER else {"ms": 3}
            axes.plot(real, imaginary, "o" if name == PAPER else ".", label=LABELS[name], **style)
        axes.axvline(0.0, color="0.6", linewidth=0.8, zorder=0)
        axes.set(xlim=limits, xlabel=r"$\mathrm{Re}\,\lambda\; r_0/U^*$")
    top = max(LEAST_HEIGHT, *(1.3 * _height(each, NEAR) for _, each in present(data)))
    panels[1].set_ylim(-top, top)
    panels[0].set_ylabel(r"$\mathrm{Im}\,\lambda\; r_0/U^*$")
    panels[0].legend(fontsize=8, frameon=False, loc="upper left")
    return figure


def findings(data: xr.Dataset) -> list[Finding]:
    """The statement about the spectrum (Fig. 3)."""
    rates = in_paper_units(data["growth_rate"]).values
    positive = rates[rates > 0.0]
    listed = ", ".join(
        f"{rate:.3f} (m = {m:.0f}, j = {j:.0f})"
        for rate, m, j in zip(
            positive, data["azimuthal_number"].values, data["wave_number"].values, strict=False
        )
    )
    far = float(np.mean(rates < -FAR * rates.max()))
    error = float(in_paper_units(data["error_estimate"]))
    return [
        finding(
            "P4",
            "N = 2, D = 10, packing 0.2, viscosity ratio 5: three eigenvalues have a positive real"
            " part",
            f"{positive.size}: {listed}; the first +- {error:.1g}",
            positive.size == POSITIVE,
            rates,
        ),
        finding(
            "P4",
            "most of the others are far in the negative",
            f"{far:.0%} decay faster than {FAR:g} times {number(rates.max())}",
            far > MOST,
            rates,
        ),
    ]


def _height(data: xr.Dataset, limits: tuple[float, float]) -> float:
    """Largest frequency of the modes with growth rates within limits."""
    real, imaginary = (in_paper_units(data[name]).values for name in ("growth_rate", "frequency"))
    inside = (real > limits[0]) & (real < limits[1])
    return float(np.abs(imaginary[inside]).max(initial=0.0))
