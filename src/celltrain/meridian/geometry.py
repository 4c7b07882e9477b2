"""Lengths of axisymmetric cells in a train, from their meridian."""

from functools import lru_cache

import numpy as np
from jaxtyping import Float

from celltrain.harmonics import Profile, legendre_functions
from celltrain.meridian.grids import Meridian, meridian_grid
from celltrain.parameters.reference_shape import profile_measures

#: Points of a meridian, pole to pole, from which lengths are taken.
POINTS = 2001


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


def volume_gradient(profile: Profile) -> Float[np.ndarray, " member"]:
    """dV/ds in the members of m = 0: those of n dS/dOmega, in r0^2."""
    # The components are polynomials of degree 2 M - 2, times a harmonic below 3 M.
    grid = meridian_grid(profile.shape[1], 2 * profile.shape[1])
    axial, radial = grid.area_vectors(profile)
    members = grid.members(0)
    return 2.0 * np.pi * (members[0] * radial + members[2] * axial) @ grid.weights
