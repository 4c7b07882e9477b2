"""The flow around the cells of a steady train, as seen from a cell (Fig. 7)."""

import itertools
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy
from jaxtyping import Bool, Float

from celltrain.meridian.geometry import meridian_points
from celltrain.parameters import CaseError
from celltrain.quantities import Quantity, Record
from celltrain.steady import Base

RADIAL, AXIAL = 41, 81
# Parts of the mean velocity below this are rest: what the velocity's rules leave (and see Fig. 7).
AT_REST = 1e-4


@dataclass(frozen=True, eq=False)
class MeridionalFlow(Record):
    """Flow in a half plane through the axis, in the frame in which the cells rest."""

    radius: Annotated[
        Float[np.ndarray, " radial"],
        Quantity("r", "r0", "distances from the axis, 0 to the wall", bulky=True),
    ]
    axial: Annotated[
        Float[np.ndarray, " axial"],
        Quantity(
            "z",
            "r0",
            "positions along the tube over one period, the cell in its middle",
            bulky=True,
        ),
    ]
    velocity: Annotated[
        Float[np.ndarray, "axial radial 2"],
        Quantity(
            "u", "U", "radial and axial velocity", ("axial", "radial", "direction"), bulky=True
        ),
    ]
    stream_function: Annotated[
        Float[np.ndarray, "axial radial"],
        Quantity(
            r"\psi",
            "U r0^2",
            "stream function, 0 on the axis",
            equation=r"u_z = (1/r) d\psi/dr, u_r = -(1/r) d\psi/dz",
            bulky=True,
        ),
    ]
    inside: Annotated[
        Bool[np.ndarray, "axial radial"],
        Quantity(
            "", "1", "which points lie inside a cell; there the velocity is nothing", bulky=True
        ),
    ]


@dataclass(frozen=True)
class Recirculation:
    """Where fluid turns between two cells, in the frame in which the cells rest.

    Where the velocity on the axis is positive, fluid runs ahead of the cells and turns back
    farther out.
    """

    stagnation_points: Annotated[
        tuple[float, ...],
        Quantity(
            "z",
            "r0",
            "places on the axis, from the middle between two cells, where the fluid changes"
            " direction",
        ),
    ]
    axis_velocity: Annotated[
        float,
        Quantity("w_z", "U", "velocity on the axis that is farthest from 0 between the cells"),
    ]
    strength: Annotated[
        float,
        Quantity(
            "",
            "1",
            "how much fluid turns back of all that passes the cells, 0 if none does",
            equation=r"\max \psi/|\psi(R)|",
        ),
    ]
    centre: Annotated[
        tuple[float, float],
        Quantity(
            "",
            "r0",
            "distance from the axis, and place from the middle between two cells, of the point"
            " around which fluid turns; NaN if there is none",
        ),
    ]


def meridional_flow(base: Base, *, radial: int = RADIAL, axial: int = AXIAL) -> MeridionalFlow:
    """The flow in the frame of the cells, on a grid of `axial` by `radial` points of a half plane.

        w = u - U_c e_z,     psi(r, z) = int_0^r w_z r' dr',

    in U and U r0^2; lines of equal psi are streamlines.

    **Raises:** `CaseError` where the velocity cannot be resolved.
    """
    from celltrain.train import fluid_velocity  # JAX: pictures of known flows need none

    period = base.train.period
    radius = np.linspace(0.0, base.train.radius, radial)
    z = np.linspace(-0.5, 0.5, axial) * period
    height, across = np.meshgrid(z, radius, indexing="ij")
    points = np.stack([across, np.zeros_like(across), height], axis=-1)
    velocity = fluid_velocity(base, points.reshape(-1, 3)).reshape(points.shape)
    relative = np.stack([velocity[..., 0], velocity[..., 2] - base.cell_velocity], axis=-1)
    inside = inside_cells(base, across, height)
    relative[inside] = 0.0
    # At the wall the fluid rests exactly, and there is no flow across the axis.
    relative[:, -1] = [0.0, -base.cell_velocity]
    relative[:, 0, 0] = 0.0
    lost = ~np.isfinite(relative).all(axis=-1)
    if lost.any():
        raise CaseError(
            f"the velocity is not known at {lost.sum()} of {lost.size} points between the cells"
            f" (diameter = {2.0 * base.train.radius:g}, packing = {base.train.packing:g}): the"
            " operator in three dimensions does not resolve cells as near to the wall; allowed:"
            " wider tubes"
        )
    stream = scipy.integrate.cumulative_simpson(relative[..., 1] * radius, x=radius, initial=0.0)
    return MeridionalFlow(radius, z, relative, stream, inside)


def inside_cells(
    base: Base,
    radius: Float[np.ndarray, "*points"],
    axial: Float[np.ndarray, "*points"],
) -> Bool[np.ndarray, "*points"]:
    """Which points of a half plane through the axis lie inside a cell, neighbours included."""
    from matplotlib.path import Path as Outline  # takes long

    half = np.stack(meridian_points(base.profile), axis=-1)
    # With its mirror image, so that the axis is no edge.
    outline = Outline(np.concatenate([half, half[::-1] * [-1.0, 1.0]]))
    found = np.zeros(np.size(radius), dtype=bool)
    for image in (-1, 0, 1):
        moved = np.ravel(axial) - image * base.train.period
        found |= outline.contains_points(np.stack([np.ravel(radius), moved], axis=-1))
    return found.reshape(np.shape(radius))


def recirculation(base: Base, flow: MeridionalFlow | None = None) -> Recirculation:
    """What turns back between the cells of a steady train.

    Points of rest are zeros of w_z on the axis; the strength of what turns is max(psi)/|psi(R)|
    (see `meridional_flow`), the fluid in the closed streamlines over that which passes the cells.

    **Arguments:** `flow`: from `meridional_flow`, if it is known already.
    """
    flow = meridional_flow(base) if flow is None else flow
    # From the middle between two cells on; the first and the last row are the same.
    period = flow.axial[-1] - flow.axial[0]
    place = np.mod(flow.axial[:-1], period) - 0.5 * period
    order = np.argsort(place)
    place = place[order]
    inside = flow.inside[:-1][order]
    on_axis = flow.velocity[:-1, 0, 1][order]
    on_axis = np.where(inside[:, 0] | (np.abs(on_axis) < AT_REST), 0.0, on_axis)
    known = np.flatnonzero(on_axis)
    stagnation = tuple(
        float(np.interp(0.0, sorted(on_axis[[a, b]]), place[[a, b]][np.argsort(on_axis[[a, b]])]))
        for a, b in itertools.pairwise(known)
        if on_axis[a] * on_axis[b] < 0.0
    )
    whole = float(np.abs(flow.stream_function[:, -1]).max())
    stream = np.where(inside, -np.inf, flow.stream_function[:-1][order])
    peak = np.unravel_index(np.argmax(stream), stream.shape)
    strength = max(float(stream[peak]) / whole, 0.0)
    turning = strength > AT_REST
    return Recirculation(
        stagnation_points=stagnation,
        axis_velocity=float(on_axis[np.argmax(np.abs(on_axis))]),
        strength=strength if turning else 0.0,
        centre=(float(flow.radius[peak[1]]), float(place[peak[0]]))
        if turning
        else (np.nan, np.nan),
    )
