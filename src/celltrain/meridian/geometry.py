"""Lengths of axisymmetric cells in a train, from their meridian."""

from functools import lru_cache

import numpy as np
from jaxtyping import Float

from celltrain.harmonics import Profile, legendre_functions
from celltrain.meridian.grids import Meridian, meridian_grid
from celltrain.parameters.reference_shape import profile_measures

#: Points of a meridian, pole to pole, from which lengths are taken.
POINTS = 2001
# Distances from the axis at which the streamwise gap is taken.
LEVELS = 801


@lru_cache(maxsize=32)
def _tables(degree: int, points: int) -> tuple[np.ndarray, np.ndarray]:
    values = legendre_functions(degree, 1, np.linspace(0.0, np.pi, points))
    return values[0], values[1]


def meridian_points(profile: Profile, points: int = POINTS) -> tuple[Meridian, Meridian]:
    """Distance from the axis and axial position along the meridian, front pole to rear pole, r0."""
    upright, across = _tables(profile.shape[1], points)
    return profile[1] @ across, profile[0] @ upright


def largest_radius(profile: Profile) -> float:
    """Largest distance of the membrane from the axis, in r0."""
    return float(meridian_points(profile)[0].max())


def size_at_rest(profile: Profile) -> tuple[float, float]:
    """Largest diameter and largest axial thickness of a cell, in r0."""
    return profile_measures(np.stack(meridian_points(profile, 401), axis=-1))


def streamwise_gap(profile: Profile, period: float) -> float:
    """Smallest streamwise distance between the membranes of neighbouring cells, in r0.

    The minimum, over the distance from the axis, of the rear of one cell less the front of the next
    one upstream (Delta in Fig. 2 of Bryngelson & Freund 2018). Negative if the cells overlap.
    """
    radius, z = meridian_points(profile)
    levels = np.linspace(0.0, radius.max() * (1.0 - 1e-6), LEVELS)
    # Each piece of the meridian contributes at the radii that it spans.
    first = np.searchsorted(levels, np.minimum(radius[:-1], radius[1:]))
    count = np.searchsorted(levels, np.maximum(radius[:-1], radius[1:])) - first
    piece = np.repeat(np.arange(len(count)), count)
    level = np.arange(len(piece)) - np.repeat(np.cumsum(count) - count, count) + first[piece]
    fraction = (levels[level] - radius[piece]) / (radius[piece + 1] - radius[piece])
    height = z[piece] + fraction * (z[piece + 1] - z[piece])
    front, rear = np.full(LEVELS, -np.inf), np.full(LEVELS, np.inf)
    np.maximum.at(front, level, height)
    np.minimum.at(rear, level, height)
    known = np.isfinite(front)
    return float(np.min(period + rear[known] - front[known]))


def volume_gradient(profile: Profile) -> Float[np.ndarray, " member"]:
    """dV/ds in the members of m = 0: those of n dS/dOmega, in r0^2."""
    # The components are polynomials of degree 2 M - 2, times a harmonic below 3 M.
    grid = meridian_grid(profile.shape[1], 2 * profile.shape[1])
    axial, radial = grid.area_vectors(profile)
    members = grid.members(0)
    return 2.0 * np.pi * (members[0] * radial + members[2] * axial) @ grid.weights


def clearance(profile: Profile, period: float, radius: float) -> float:
    """Smallest distance of a cell from its neighbours and from the wall, in r0.

    Upper bounds, from points on the meridians.
    """
    x, z = meridian_points(profile, 401)
    side = radius - float(x.max())
    # In a plane through the axis each cell is its meridian and the meridian's mirror image.
    apart = [np.hypot(x[:, None] - sign * x, z[:, None] - z - period).min() for sign in (1.0, -1.0)]
    return min(side, *map(float, apart))


def crosses_itself(profile: Profile, points: int = 201) -> bool:
    """Whether the meridian crosses the axis or itself, so that it is the shape of no cell."""
    radius, axial = meridian_points(profile, points)
    if (radius[1:-1] <= 0.0).any():
        return True
    place = np.stack([radius, axial], axis=-1)
    starts, along = place[:-1], np.diff(place, axis=0)
    between = starts[None] - starts[:, None]
    turned = _cross(along[:, None], along[None])
    with np.errstate(divide="ignore", invalid="ignore"):
        here = _cross(between, along[None]) / turned
        there = _cross(between, along[:, None]) / turned
    meet = (here > 0.0) & (here < 1.0) & (there > 0.0) & (there < 1.0)
    return bool(np.triu(meet, 2).any())


def _cross(
    first: Float[np.ndarray, "... 2"], second: Float[np.ndarray, "... 2"]
) -> Float[np.ndarray, "..."]:
    return first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
