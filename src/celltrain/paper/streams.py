"""Streamlines between the cells of steady trains: Fig. 7, and the statement about them."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from celltrain.diagnostics.streamlines import AT_REST, MeridionalFlow
from celltrain.meridian.geometry import meridian_points
from celltrain.paper.finding import Finding, finding
from celltrain.paper.resolutions import Resolutions, best
from celltrain.paper.trains import CELLS, dataset
from celltrain.parameters import Train
from celltrain.pictures.streamlines import streamline_panel
from celltrain.pictures.style import in_style
from celltrain.steady import Base, steady

DIAMETER = 6.0
#: Packings that are looked at, and those that are drawn as in the paper.
PACKINGS, DRAWN = (0.3, 0.4, 0.45, 0.5, 0.55, 0.6, 0.7), (0.3, 0.5, 0.7)
#: Where the regions join on the axis, where the fluid nearly rests there, where they are small.
JOINED, RESTING, SMALL = (0.3, 0.4), (0.45, 0.5, 0.55), (0.6, 0.7)
#: What counts as rest on the axis, U: a hundredth of the mean velocity.
NEARLY = 0.01
POINTS = 301


def compute(degree: int | None) -> xr.Dataset:
    """The flow in the frame of the cells on a half plane, and what turns back in it."""
    from celltrain.diagnostics import meridional_flow, recirculation  # JAX

    flows, outlines, numbers = [], [], []
    base: Base | None = None
    for packing in PACKINGS:
        train = Train(diameter=DIAMETER, packing=packing, cells=CELLS, degree=degree)
        base = steady(train, start=base, estimate_error=False)
        flow = meridional_flow(base)
        found = recirculation(base, flow)
        flows.append(flow)
        outlines.append(np.stack(meridian_points(base.profile, POINTS)))
        numbers.append((base.train.period, found.axis_velocity, found.strength, *found.centre))
    dims = ("packing", "axial", "radial")
    period, axis, strength, across, along = np.array(numbers).T
    one = ("packing",)
    return dataset(
        {
            "velocity": (
                (*dims, "component"),
                np.stack([each.velocity for each in flows]).astype("float32"),
                "U",
                "radial and axial velocity in the frame of the cells",
            ),
            "stream_function": (
                dims,
                np.stack([each.stream_function for each in flows]).astype("float32"),
                "U r0^2",
                "stream function, 0 on the axis",
            ),
            "inside": (dims, np.stack([each.inside for each in flows]).astype("int8"), "1", ""),
            "outline": (("packing", "axis", "point"), np.stack(outlines), "r0", "meridian"),
            "period": (one, period, "r0", "period of a cell"),
            "axis_velocity": (one, axis, "U", "velocity on the axis, farthest from 0"),
            "strength": (one, strength, "1", "fluid that turns back over that which passes"),
            "centre_radius": (one, across, "r0", "where it turns: distance from the axis"),
            "centre_axial": (one, along, "r0", "and place from the middle between cells"),
        },
        {
            "packing": list(PACKINGS),
            "radius": ("radial", flows[0].radius, {"units": "r0"}),
            "component": ["radial", "axial"],
            "axis": ["distance", "height"],
        },
        f"flow between the cells of steady trains, D = {DIAMETER:g}",
    )


def flow_of(data: xr.Dataset, packing: float) -> MeridionalFlow:
    """The flow of one packing as it was computed."""
    at = data.sel(packing=packing)
    axial = np.linspace(-0.5, 0.5, at.sizes["axial"]) * float(at["period"])
    return MeridionalFlow(
        at["radius"].values,
        axial,
        at["velocity"].values.astype(float),
        at["stream_function"].values.astype(float),
        at["inside"].values.astype(bool),
    )


@in_style()
def draw(data: Resolutions) -> Figure:
    """Fig. 7: streamlines in the frame of the cells, converged if that is there."""
    chosen = best(data)
    periods = [float(chosen["period"].sel(packing=each)) for each in DRAWN]
    figure = Figure(figsize=(9.6, 3.4), layout="constrained")
    panels = figure.subplots(1, len(DRAWN), width_ratios=periods)
    for axes, packing in zip(panels, DRAWN, strict=True):
        outline = chosen["outline"].sel(packing=packing).values
        streamline_panel(axes, flow_of(chosen, packing), outline)
        axes.set_title(rf"$\phi$ = {packing:g}", fontsize=10)
    for axes in panels[1:]:
        axes.set_ylabel("")
    return figure


def findings(data: xr.Dataset) -> list[Finding]:
    """The statement about the flow between cells (Fig. 7)."""
    axis, strength = data["axis_velocity"], data["strength"]

    def listed(values: xr.DataArray, packings: tuple[float, ...], form: str) -> str:
        return ", ".join(f"{each:g}: {float(values.sel(packing=each)):{form}}" for each in packings)

    joined = axis.sel(packing=list(JOINED))
    resting = abs(axis.sel(packing=list(RESTING)))
    small = strength.sel(packing=list(SMALL))
    return [
        finding(
            "P10",
            "D = 6: for packings up to 0.4 the regions that turn back join on the centre line",
            f"velocity there, U: {listed(axis, JOINED, '+.1e')}",
            bool((joined > NEARLY).all()),
            joined,
        ),
        finding(
            "P10",
            "from 0.4 to 0.55 the fluid nearly rests there",
            f"velocity there, U: {listed(axis, RESTING, '+.1e')}",
            bool((resting < NEARLY).all()),
            resting,
        ),
        finding(
            "P10",
            "from 0.6 on only small regions beside the cells turn back",
            f"fluid that turns back over that which passes: {listed(strength, SMALL, '.0e')}"
            f" (less than {AT_REST:g} is not told from none)",
            bool(((small > 0.0) & (small < strength.sel(packing=JOINED[0]))).all()),
            small,
        ),
    ]
