"""Spectra of deformation: Fig. 10, and the paper's statement about them."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from celltrain.diagnostics import deformation_spectrum
from celltrain.paper.curves import side_by_side
from celltrain.paper.finding import Finding, finding
from celltrain.paper.resolutions import LABELS, PAPER, Resolutions, Style, present
from celltrain.paper.trains import CORNERS, PAPER_DEGREE, analysed, dataset

#: Degrees of the disturbances from here on count as short waves: half of the paper's M.
SHORT_WAVES = PAPER_DEGREE // 2
#: Largest degree of a case that is kept.
MOST = 48
#: The train that the paper shows: D = 10, packing 0.7.
SHOWN = 3


def compute(degree: int | None) -> xr.Dataset:
    """E_n of Eq. (16), sum 1, of the leading mode and of what grows fastest at first."""
    shares = np.full((len(CORNERS), 2, MOST), np.nan)
    for row, (diameter, packing) in enumerate(CORNERS):
        result = analysed(degree, diameter=diameter, packing=packing)
        for column, shape in enumerate((result.shape(result.leading), result.transient_shape())):
            spectrum = deformation_spectrum(shape)
            shares[row, column, : len(spectrum)] = spectrum / spectrum.sum()
    return dataset(
        {
            "spectrum": (
                ("train", "disturbance", "n"),
                shares,
                "1",
                "share of each degree n in a disturbance (Eq. 16)",
            )
        },
        {
            "disturbance": ["v_alpha", "v_eta"],
            "n": np.arange(MOST),
            "diameter": ("train", [each[0] for each in CORNERS], {"units": "r0"}),
            "packing": ("train", [each[1] for each in CORNERS]),
        },
        "spectra of the deformation by the leading mode and by what grows fastest at first",
    )


def draw(data: Resolutions) -> Figure:
    """Fig. 10: the spectra of both disturbances, D = 10, packing 0.7."""
    figure, [axes] = side_by_side(1)
    axes.set_title("")
    for name, each in present(data):
        for label, color in (("v_eta", "C1"), ("v_alpha", "C0")):
            shares = each["spectrum"].isel(train=SHOWN).sel(disturbance=label).values
            words = rf"$v_\{label[2:]}$, {LABELS[name]}"
            style: Style = {"marker": "o", "mfc": "none", "ls": "none"} if name == PAPER else {}
            axes.semilogy(shares, color=color, ms=4, label=words, **style)
    axes.set(xlabel="$n$", ylabel=r"$E_n/\sum_n E_n$", ylim=(1e-10, 2.0))
    axes.legend(fontsize=8, frameon=False)
    return figure


def findings(data: xr.Dataset) -> list[Finding]:
    """The statement about the spectra (Fig. 10)."""
    short = data["spectrum"].sel(n=slice(SHORT_WAVES, None)).sum("n", skipna=True)
    slow, fast = (short.sel(disturbance=name) for name in ("v_alpha", "v_eta"))
    listed = "; ".join(f"{float(a):.1e}, {float(b):.1e}" for a, b in zip(slow, fast, strict=True))
    return [
        finding(
            "P15",
            "the spectrum of v_alpha decays faster than that of v_eta",
            f"share of n >= {SHORT_WAVES} in v_alpha, v_eta, four trains: {listed}",
            bool((slow < fast).all()),
            data["spectrum"].isel(n=0),
        )
    ]
