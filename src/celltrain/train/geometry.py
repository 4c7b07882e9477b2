"""Lengths of an axisymmetric train that are reported with it."""

import numpy as np
from jaxtyping import Float

from celltrain.harmonics import real_harmonics


def meridian(
    shape: Float[np.ndarray, "3 coefficient"], points: int = 2001
) -> tuple[Float[np.ndarray, " point"], Float[np.ndarray, " point"]]:
    """Distance from the axis and axial position along the meridian phi = 0, pole to pole."""
    theta = np.linspace(0.0, np.pi, points)
    degree = int(np.sqrt(shape.shape[-1]))
    x, _, z = shape @ real_harmonics(degree, theta, np.zeros_like(theta)).T
    return x, z


def largest_radius(shape: Float[np.ndarray, "3 coefficient"]) -> float:
    """Largest distance of an axisymmetric cell's membrane from the axis, in r0."""
    return float(meridian(shape)[0].max())


def streamwise_gap(shape: Float[np.ndarray, "3 coefficient"], period: float) -> float:
    """Smallest streamwise distance between the membranes of neighbouring cells, in r0.

    The minimum, over the distance from the axis, of the rear of one cell less the front of the next
    one upstream (Delta in Fig. 2 of Bryngelson & Freund 2018). Negative if the cells overlap.
    """
    radius, z = meridian(shape)
    levels = np.linspace(0.0, radius.max() * (1.0 - 1e-6), 801)
    front, rear = np.full_like(levels, -np.inf), np.full_like(levels, np.inf)
    # Each piece of the meridian contributes at the radii that it spans.
    inner, outer = np.minimum(radius[:-1], radius[1:]), np.maximum(radius[:-1], radius[1:])
    for i in np.flatnonzero(outer > inner):
        span = slice(*np.searchsorted(levels, (inner[i], outer[i])))
        here = levels[span]
        fraction = (here - radius[i]) / (radius[i + 1] - radius[i])
        height = z[i] + fraction * (z[i + 1] - z[i])
        front[span], rear[span] = np.maximum(front[span], height), np.minimum(rear[span], height)
    known = np.isfinite(front)
    return float(np.min(period + rear[known] - front[known]))
