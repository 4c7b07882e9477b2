"""How close axisymmetric cells of a train are, from their meridian: no search, and no JAX."""

import numpy as np
from jaxtyping import Float

from celltrain.harmonics import Profile
from celltrain.meridian.geometry import meridian_points

# Distances from the axis at which the streamwise gap is taken.
LEVELS = 801


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
    """Whether the meridian crosses the axis or itself, as no cell's does."""
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
