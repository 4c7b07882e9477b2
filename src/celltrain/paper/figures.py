"""The paper's figures: what to compute, how to draw it, what it should show."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import files

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from celltrain.paper import (
    base_flows,
    disturbed,
    eigenvalues,
    initial,
    interactions,
    spectra,
    strain,
    streams,
)
from celltrain.paper.cell_volume import (
    draw_family,
    draw_over_volume,
    family,
    family_findings,
    volume_findings,
)
from celltrain.paper.finding import Finding, in_paper_units
from celltrain.paper.flow_strength import draw_over_flow, flow_findings
from celltrain.paper.resolutions import Resolutions, label_of, present
from celltrain.paper.statements import CONTOURS, growth_findings, transient_findings
from celltrain.paper.viscosity_ratio import (
    draw_over_packing,
    draw_over_ratio,
    packing_findings,
    ratio_findings,
)
from celltrain.parameters import read_case
from celltrain.pictures.study import mark_cases
from celltrain.pictures.style import VERMILION
from celltrain.study import Study, make_study


@dataclass(frozen=True)
class PaperFigure:
    """One figure: the name of its study, its picture, and the paper's statements about it.

    `compute` makes the data of a figure that is no study, at a degree, or converged without one.
    `needs` names what is no part of it: simulations that take hours.
    """

    study: str
    draw: Callable[[Resolutions], Figure]
    findings: Callable[[xr.Dataset], list[Finding]]
    compute: Callable[[int | None], xr.Dataset] | None = None
    needs: str = ""


def paper_study(figure: PaperFigure, *, quick: bool, degree: int | None = None) -> Study:
    """The study of a figure; the quick one is coarser in everything.

    **Arguments:** `degree`: of all cases of the full study; unless given it rises for each until
    the growth rate is known.
    """
    name = f"{figure.study}-quick.toml" if quick else f"{figure.study}.toml"
    content = read_case(str(files("celltrain.paper").joinpath(name)))
    if degree is not None:
        case = content["case"]
        assert isinstance(case, dict)
        content["case"] = case | {"degree": degree}
    return make_study(content)


def draw_growth_map(data: Resolutions) -> Figure:
    """Fig. 6(a): log10 of alpha over packing and diameter, in the paper's unit.

    Below 1e-3, also where nothing grows, the map has one colour, as the paper's. Dashed: the
    contours at the paper's degree beside the converged map.
    """

    def powers(each: xr.Dataset) -> xr.DataArray:
        alpha = in_paper_units(each["spectral_abscissa"])
        logarithms = xr.apply_ufunc(np.log10, alpha.clip(min=1e-4))
        return alpha.copy(data=logarithms.values)

    return _draw(
        {label_of(name, each): powers(each) for name, each in present(data)},
        np.arange(-3.0, -0.49, 0.25),
        (-3.0, -2.5, -2.0, -1.5, -1.0),
        r"$\log_{10}(\alpha\, r_0/U^*)$",
    )


def draw_transient_map(data: Resolutions) -> Figure:
    """Fig. 8(a): eta over packing and diameter, in the paper's unit, with the paper's contours."""
    eta = {
        label_of(name, each): in_paper_units(each["numerical_abscissa"])
        for name, each in present(data)
    }
    return _draw(eta, np.arange(10.0, 101.0, 6.0), CONTOURS, r"$\eta\, r_0/U^*$")


def _draw(
    maps: dict[str, xr.DataArray],
    levels: np.ndarray,
    contours: tuple[float, ...],
    label: str,
) -> Figure:
    """The first map with its contours, and dashed those of the others, by what they are called."""
    figure = Figure(figsize=(5.6, 4.4), dpi=200, layout="constrained")
    axes = figure.subplots()
    for number, (name, values) in enumerate(maps.items()):
        values = values.transpose("diameter", "packing")
        grid = values.packing, values.diameter, np.ma.masked_invalid(values.values)
        if number == 0:
            filled = axes.contourf(*grid, levels=levels, cmap="viridis", extend="both")
        lines = axes.contour(
            *grid,
            levels=contours,
            colors="k" if number == 0 else VERMILION,
            linestyles="solid" if number == 0 else "dashed",
            linewidths=0.9,
        )
        if number == 0:
            axes.clabel(lines, fontsize=8)
            mark_cases(axes, values)
        color, style = ("k", "-") if number == 0 else (VERMILION, "--")
        axes.plot([], [], style, color=color, linewidth=0.9, label=name)
    figure.colorbar(filled, ax=axes, label=label)
    axes.set(xlabel=r"$\phi$", ylabel=r"$D/r_0$")
    figure.legend(loc="outside upper left", ncols=2, fontsize=8, frameon=False)
    return figure


SIMULATIONS = "simulations: python validation/run.py "
#: The figures by their names on the command line. Those of one study share its results.
FIGURES = {
    "fig3": PaperFigure("eigenvalues", eigenvalues.draw, eigenvalues.findings, eigenvalues.compute),
    "fig4": PaperFigure(
        "initial-small",
        initial.draw_small,
        initial.small_findings,
        initial.small,
        f"{SIMULATIONS}transients --march",
    ),
    "fig5": PaperFigure("base-flows", base_flows.draw, base_flows.findings, base_flows.compute),
    "fig6": PaperFigure("map", draw_growth_map, growth_findings),
    "fig7": PaperFigure("streamlines", streams.draw, streams.findings, streams.compute),
    "fig8": PaperFigure("map", draw_transient_map, transient_findings),
    "fig9": PaperFigure(
        "initial-large",
        initial.draw_large,
        initial.large_findings,
        initial.large,
        f"{SIMULATIONS}transients --march",
    ),
    "fig10": PaperFigure("spectra", spectra.draw, spectra.findings, spectra.compute),
    "fig11": PaperFigure(
        "disturbed",
        disturbed.draw,
        disturbed.findings,
        disturbed.compute,
        f"{SIMULATIONS}breakup --simulate leading random sparse",
    ),
    "fig13": PaperFigure("viscosity-packing", draw_over_packing, packing_findings),
    "fig14": PaperFigure("viscosity-ratio", draw_over_ratio, ratio_findings),
    "fig16": PaperFigure("flow-strength", draw_over_flow, flow_findings),
    "fig17": PaperFigure("shapes", draw_family, family_findings, family),
    "fig19": PaperFigure("cell-volume", draw_over_volume, volume_findings),
    "fig20": PaperFigure(
        "interactions", interactions.draw, interactions.findings, interactions.compute
    ),
    "table1": PaperFigure("strain", strain.draw, strain.findings, strain.compute),
}
