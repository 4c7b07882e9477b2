"""The steady trains that the paper shows: Figs. 5, 15 and 18, and the statement about them."""

from collections.abc import Iterator

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from celltrain.meridian.geometry import meridian_points
from celltrain.paper.finding import Finding, finding
from celltrain.paper.resolutions import LABELS, PAPER, Resolutions, Style, best, present
from celltrain.paper.trains import CELLS, CORNERS, dataset
from celltrain.parameters import Train, paper_units
from celltrain.steady import Base, steady

#: The paper's criterion of convergence, velocity along the normal in U.
CONVERGED = 1e-4
#: Volumes on the way to the least and the largest one of Fig. 18.
VOLUMES = ((0.55, 0.4), (0.7, 0.75, 0.8, 0.84, 0.86))
#: The least and the largest Ca of Fig. 15, as the paper counts it.
CAPILLARY = (0.4, 20.5)
#: Points of an outline, and half of what is shown of the tube, r0.
POINTS, HALF_WINDOW = 201, 8.5


def trains(degree: int | None) -> Iterator[tuple[str, Base]]:
    """The trains with their names in the paper."""
    for letter, (diameter, packing) in zip("abcd", CORNERS, strict=True):
        train = Train(diameter=diameter, packing=packing, cells=CELLS, degree=degree)
        yield (
            f"5 ({letter}): D = {diameter:g}, packing {packing:g}",
            steady(train, estimate_error=False),
        )
    train = Train(diameter=8, packing=0.2, cells=CELLS, degree=degree)
    base = steady(train, estimate_error=False)
    for letter, capillary in zip("ab", CAPILLARY, strict=True):
        changed = train.changed(capillary_number=paper_units.capillary_number_from_paper(capillary))
        base = steady(changed, start=base, estimate_error=False)
        yield f"15 ({letter}): D = 8, packing 0.2, Ca = {capillary:g}", base
    dense = steady(train.changed(packing=0.7), estimate_error=False)
    for letter, volumes in zip("ab", VOLUMES, strict=True):
        base = dense
        for volume in volumes:
            case = train.changed(packing=0.7, reduced_volume=volume)
            base = steady(case, start=base, estimate_error=False)
        yield f"18 ({letter}): D = 8, packing 0.7, v = {volumes[-1]:g}", base


def compute(degree: int | None) -> xr.Dataset:
    """Outlines and numbers of the trains; without a degree it rises until U_c is known."""
    found = list(trains(degree))
    bases = [base for _, base in found]
    outlines = np.stack([np.stack(meridian_points(base.profile, POINTS)) for base in bases])
    dims = ("train",)

    def numbers(name: str, unit: str, words: str) -> tuple[object, ...]:
        return dims, [float(getattr(base, name)) for base in bases], unit, words

    return dataset(
        {
            "outline": (("train", "axis", "point"), outlines, "r0", "meridian of a cell"),
            "period": (dims, [base.train.period for base in bases], "r0", "period of a cell"),
            "radius": (dims, [base.train.radius for base in bases], "r0", "radius of the tube"),
            "taken_degree": (dims, [base.train.degree for base in bases], "1", "degree"),
            "cell_velocity": numbers("cell_velocity", "U", "velocity of the cells"),
            "gap": numbers("gap", "r0", "axial distance between cells"),
            "largest_radius": numbers("largest_radius", "r0", "largest radius of a cell"),
            "effective_viscosity": numbers("effective_viscosity", "mu", "effective viscosity"),
            "residual": numbers("residual", "U", "largest velocity against the moving train"),
            "truncation_error": numbers("truncation_error", "U", "the same before the cut at M"),
        },
        {"train": [name for name, _ in found], "axis": ["distance", "height"]},
        "steady trains of Figs. 5, 15 and 18",
    )


def draw(data: Resolutions) -> Figure:
    """Figs. 5, 15 and 18: sections along the axis, the flow to the right."""
    names = [str(each) for each in best(data)["train"].values]
    figure = Figure(figsize=(9.0, 7.4), dpi=200, layout="constrained")
    for axes, name in zip(figure.subplots(4, 2).ravel(), names, strict=True):
        for resolution, each in present(data):
            at = each.sel(train=name)
            radius, height = at["outline"].values
            along = np.concatenate([height, height[::-1]])
            across = np.concatenate([radius, -radius[::-1]])
            period = float(at["period"])
            cells = min(CELLS, int(2.0 * HALF_WINDOW / period))
            for cell in range(cells):
                style: Style = {"fc": "#E8A5A3", "ec": "#7A1210"}
                if resolution == PAPER:
                    style = {"fc": "none", "ec": "k", "ls": ":", "lw": 1.0}
                axes.fill(along + cell * period, across, **style)
        for side in (-1.0, 1.0):
            axes.axhline(side * float(at["radius"]), color="0.25", linewidth=1.2)
        axes.set_aspect("equal")
        middle = float(np.mean(along)) + 0.5 * (cells - 1) * period
        axes.set_xlim(middle - HALF_WINDOW, middle + HALF_WINDOW)
        axes.axis("off")
        axes.set_title(f"Fig. {name}", fontsize=9, loc="left")
    if PAPER in data and len(data) > 1:
        figure.supxlabel(f"full: converged; dotted: {LABELS[PAPER]}", fontsize=9)
    return figure


def findings(data: xr.Dataset) -> list[Finding]:
    """The statement about the steady trains (Fig. 5)."""
    chosen = data.isel(train=slice(0, len(CORNERS)))
    distance, height = (chosen["outline"].sel(axis=name) for name in ("distance", "height"))
    foremost, rearmost = height.max("point"), height.min("point")
    on_axis = height.isel(point=[0, -1])
    front, rear = on_axis.max("point"), on_axis.min("point")
    widest = height.isel(point=distance.argmax("point"))
    bullet = (
        (foremost - front < 1e-3)
        & (rear - rearmost > 1e-3)
        & (widest < 0.5 * (foremost + rearmost))
    )
    worst = float(chosen["residual"].max())
    return [
        finding(
            "P1",
            "D = 6 and 10, packing 0.2 and 0.7: bullets, foremost on the axis in front, hollow in"
            " the rear, and widest behind the middle",
            f"{int(bullet.sum())} of {bullet.size}",
            bool(bullet.all()),
            chosen["residual"],
        ),
        finding(
            "P1",
            f"converged at velocities along the normal below {CONVERGED:.0e} U",
            f"largest velocity against the train {worst:.0e} U; what the degree leaves out"
            f" {float(chosen['truncation_error'].max()):.0e} U",
            worst < CONVERGED,
            chosen["residual"],
        ),
    ]
