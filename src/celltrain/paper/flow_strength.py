"""Strength of the flow: Fig. 16, and the paper's statements about it (Sec. V D)."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from celltrain.paper.curves import sparse_and_dense
from celltrain.paper.finding import (
    DENSE,
    SPARSE,
    Finding,
    at,
    finding,
    first_case,
    in_paper_units,
    number,
)
from celltrain.paper.resolutions import Resolutions
from celltrain.parameters import paper_units
from celltrain.parameters.dimension import SURFACE_MODULUS

#: The paper's usual capillary number.
USUAL = 0.66
#: What "by a factor of about two" may mean, and "by 0.11 r0".
ABOUT_TWO, WALL_FALL, WALL_LEEWAY = (1.5, 2.7), 0.11, 0.03
#: How far slopes that "match" may differ.
MATCH = (0.5, 2.0)
#: Fewest dense trains that tell how alpha goes with Ca.
FEWEST = 4


def in_paper_axes(data: xr.Dataset) -> xr.Dataset:
    """A study in SI over mean velocities, over Ca as the paper counts it and diameters in r0."""
    train = first_case(data)
    scales = train.scales
    modulus = scales.si(SURFACE_MODULUS, train.cell.shear_modulus)
    capillary = scales.plasma_viscosity * data["mean_velocity"].values / modulus
    return data.assign_coords(
        diameter=data["diameter"].values / scales.radius,
        mean_velocity=paper_units.capillary_number(capillary),
    ).rename(mean_velocity="Ca")


def draw_over_flow(data: Resolutions) -> Figure:
    """Fig. 16: alpha over Ca for sparse and dense trains, in the paper's units."""
    converted = {name: in_paper_axes(each) for name, each in data.items()}
    figure, panels = sparse_and_dense(converted, "Ca", USUAL)
    for axes in panels:
        axes.set(xscale="log", xlabel="Ca", ylim=(0.0, None))
    return figure


def flow_findings(data: xr.Dataset) -> list[Finding]:
    """The statements about the strength of the flow (Fig. 16), in each tube."""
    data = in_paper_axes(data)
    return [each for diameter in data.diameter.values for each in _of_tube(data, diameter)]


def _of_tube(data: xr.Dataset, diameter: float) -> list[Finding]:
    alpha, error = (
        in_paper_units(at(data[name], diameter=diameter))
        for name in ("spectral_abscissa", "error_estimate")
    )
    thin = at(alpha, packing=SPARSE)
    # Dense trains in strong flow are not always found: what is known has to tell.
    thick = at(alpha, packing=DENSE).dropna("Ca")

    def told(packing: float, capillary: float) -> str:
        place = {"packing": packing, "Ca": capillary}
        return f"{number(at(alpha, **place), at(error, **place))} at Ca = {capillary:g}"

    first, last = float(thin.Ca[0]), float(thin.Ca[-1])
    fall = float(at(thin, Ca=1.0) / at(thin, Ca=10.0))
    radius = at(data["largest_radius"], diameter=diameter, packing=SPARSE)
    # The distance to the wall falls as the largest radius grows.
    nearer = float(radius[-1] - radius[0])
    gap = at(data["gap"], diameter=diameter, packing=DENSE).dropna("Ca")
    enough = min(thick.size, gap.size) >= FEWEST
    rises, falls = (_slope(thick), -_slope(gap)) if enough else (np.nan, np.nan)
    ends = [float(each) for each in thick.Ca[[0, -1]]] if thick.size else [first, last]
    return [
        finding(
            "P24",
            f"D = {diameter:g}, packing {SPARSE:g}: alpha falls with Ca",
            f"{told(SPARSE, first)}, {told(SPARSE, last)}; {_share(-thin):.0%} of all steps fall",
            float(thin[-1]) < float(thin[0]),
            thin,
        ),
        finding(
            "P24",
            f"D = {diameter:g}, packing {SPARSE:g}: by about a factor of 2 from Ca = 1 to 10",
            f"a factor {fall:.2f}: {told(SPARSE, 1.0)}, {told(SPARSE, 10.0)}",
            ABOUT_TWO[0] < fall < ABOUT_TWO[1],
            [fall],
        ),
        finding(
            "P24",
            f"D = {diameter:g}, packing {SPARSE:g}: the distance from the wall falls by"
            f" {WALL_FALL:g} r0 over all Ca",
            f"by {nearer:.3f} r0 from Ca = {first:.3g} to {last:.3g}",
            abs(nearer - WALL_FALL) < WALL_LEEWAY,
            radius,
        ),
        finding(
            "P25",
            f"D = {diameter:g}, packing {DENSE:g}: alpha rises with Ca",
            f"{told(DENSE, ends[0])}, {told(DENSE, ends[1])}; {_share(thick):.0%} of the steps"
            f" between {thick.size} trains rise",
            thick.size > 1 and _share(thick) == 1.0,
            thick if thick.size >= FEWEST else [],
        ),
        finding(
            "P25",
            f"D = {diameter:g}, packing {DENSE:g}: at the rate at which the gap falls",
            f"d ln alpha/d ln Ca = {rises:.2f}, d ln gap/d ln Ca = {-falls:.2f}; gap"
            f" {float(gap.max()):.3f} to {float(gap.min()):.3f} r0"
            if enough
            else "",
            enough and falls > 0.0 and MATCH[0] < rises / falls < MATCH[1],
            [rises, falls],
        ),
    ]


def _share(values: xr.DataArray) -> float:
    """Share of the steps along a curve that rise."""
    steps = np.diff(values.values)
    return float(np.mean(steps > 0.0)) if steps.size else float("nan")


def _slope(values: xr.DataArray) -> float:
    """Slope of a straight line through a curve with logarithmic axes; nan if it is not positive."""
    if not (values > 0.0).all():
        return float("nan")
    return float(np.polyfit(np.log(values.Ca.values), np.log(values.values), 1)[0])
