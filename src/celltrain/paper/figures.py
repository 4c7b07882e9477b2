"""The paper's figures: what to compute, how to draw it, what it should show."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from celltrain.paper.cell_volume import (
    draw_family,
    draw_over_volume,
    family,
    family_findings,
    volume_findings,
)
from celltrain.paper.finding import Finding, in_paper_units
from celltrain.paper.flow_strength import draw_over_flow, flow_findings
from celltrain.paper.statements import CONTOURS, growth_findings, transient_findings
from celltrain.paper.viscosity_ratio import (
    draw_over_packing,
    draw_over_ratio,
    packing_findings,
    ratio_findings,
)
from celltrain.parameters import read_case
from celltrain.pictures.study import mark_cases
from celltrain.study import Study, make_study


@dataclass(frozen=True)
class PaperFigure:
    """One figure: the name of its study, its picture, and the paper's statements about it.

    `compute` makes the data of a figure that is no study, from whether it should be quick.
    """

    study: str
    draw: Callable[[xr.Dataset, Path], Path]
    findings: Callable[[xr.Dataset], list[Finding]]
    compute: Callable[[bool], xr.Dataset] | None = None


#: The degree at which the paper computed.
PAPER_DEGREE = 12


def paper_study(figure: PaperFigure, *, quick: bool, degree: int | None = None) -> Study:
    """The study of a figure; the quick one is coarser in everything.

    **Arguments:** `degree`: of all cases of the full study; unless given it rises for each until
    the growth rate is known.
    """
    name = f"{figure.study}-quick.toml" if quick else f"{figure.study}.toml"
    content = read_case(str(files("celltrain.paper").joinpath(name)))
    if degree is not None:
        content["case"] = {**content["case"], "degree": degree}
    return make_study(content)


def draw_growth_map(data: xr.Dataset, path: Path) -> Path:
    """Fig. 6(a): log10 of alpha over packing and diameter, in the paper's unit.

    Below 1e-3, also where nothing grows, the map has one colour, as the paper's.

    Raises:
        OSError: if the picture cannot be written.
    """
    alpha = in_paper_units(data["spectral_abscissa"])
    powers = xr.apply_ufunc(np.log10, alpha.clip(min=1e-4))
    return _draw(
        alpha.copy(data=powers.values),
        np.arange(-3.0, -0.49, 0.25),
        (-3.0, -2.5, -2.0, -1.5, -1.0),
        r"$\log_{10}(\alpha\, r_0/U^*)$",
        path,
    )


def draw_transient_map(data: xr.Dataset, path: Path) -> Path:
    """Fig. 8(a): eta over packing and diameter, in the paper's unit, with the paper's contours.

    Raises:
        OSError: if the picture cannot be written.
    """
    eta = in_paper_units(data["numerical_abscissa"])
    return _draw(eta, np.arange(10.0, 101.0, 6.0), CONTOURS, r"$\eta\, r_0/U^*$", path)


def _draw(
    values: xr.DataArray,
    levels: np.ndarray,
    contours: tuple[float, ...],
    label: str,
    path: Path,
) -> Path:
    values = values.transpose("diameter", "packing")
    known = np.ma.masked_invalid(values.values)
    figure = Figure(figsize=(5.6, 4.4), dpi=200, layout="constrained")
    axes = figure.subplots()
    filled = axes.contourf(
        values.packing, values.diameter, known, levels=levels, cmap="viridis", extend="both"
    )
    lines = axes.contour(
        values.packing,
        values.diameter,
        known,
        levels=contours,
        colors="k",
        linestyles="solid",
        linewidths=0.9,
    )
    axes.clabel(lines, fontsize=8)
    mark_cases(axes, values)
    figure.colorbar(filled, ax=axes, label=label)
    axes.set(xlabel=r"$\phi$", ylabel=r"$D/r_0$")
    figure.savefig(path)
    return path


#: The figures by their names on the command line. Those of one study share its results.
FIGURES = {
    "fig6": PaperFigure("map", draw_growth_map, growth_findings),
    "fig8": PaperFigure("map", draw_transient_map, transient_findings),
    "fig13": PaperFigure("viscosity-packing", draw_over_packing, packing_findings),
    "fig14": PaperFigure("viscosity-ratio", draw_over_ratio, ratio_findings),
    "fig16": PaperFigure("flow-strength", draw_over_flow, flow_findings),
    "fig17": PaperFigure("shapes", draw_family, family_findings, family),
    "fig19": PaperFigure("cell-volume", draw_over_volume, volume_findings),
}
