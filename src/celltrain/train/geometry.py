"""Lengths of an axisymmetric train that are reported with it."""

import numpy as np
from jaxtyping import Float

from celltrain.harmonics import real_harmonics
from celltrain.harmonics.grid import sphere_grid
from celltrain.harmonics.tables import harmonic_tables
from celltrain.parameters.reference_shape import profile_measures


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


def size_at_rest(shape: Float[np.ndarray, "3 coefficient"]) -> tuple[float, float]:
    """Largest diameter and largest axial thickness of an axisymmetric cell, in r0."""
    return profile_measures(np.stack(meridian(shape), axis=-1))


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


def clearance(shape: Float[np.ndarray, "3 coefficient"], period: float, radius: float) -> float:
    """Smallest distance of an axisymmetric cell from its neighbours and from the wall, in r0.

    Upper bounds, from points on the meridians.
    """
    x, z = meridian(shape, 401)
    side = radius - float(x.max())
    # In a plane through the axis each cell is its meridian and the meridian's mirror image.
    apart = [np.hypot(x[:, None] - sign * x, z[:, None] - z - period).min() for sign in (1.0, -1.0)]
    return min(side, *map(float, apart))


def area_vectors(
    shape: Float[np.ndarray, "3 coefficient"],
) -> tuple[
    Float[np.ndarray, "point 3"],
    Float[np.ndarray, " point"],
    Float[np.ndarray, "point coefficient"],
]:
    """Outward n dS/dOmega on a grid, with the grid's weights and harmonics.

    The components are polynomials of degree 2 M - 2 on the sphere, so the grid of order 2 M
    integrates them against any harmonic of the shape exactly.
    """
    degree = int(np.sqrt(shape.shape[-1]))
    grid = sphere_grid(degree, 2 * degree)
    theta, phi = grid.points()
    tables = harmonic_tables(degree, theta, phi)
    cross = np.cross(np.asarray(tables.d_theta) @ shape.T, np.asarray(tables.d_phi) @ shape.T)
    return cross / np.sin(theta)[:, None], np.asarray(grid.weights), np.asarray(grid.values)


def volume_gradient(
    shape: Float[np.ndarray, "3 coefficient"],
) -> Float[np.ndarray, "3 coefficient"]:
    """dV/ds: the coefficients of n dS/dOmega, in r0^2."""
    vectors, weights, values = area_vectors(shape)
    return (vectors * weights[:, None]).T @ values
