"""Axisymmetric shapes without swirl, given by their meridian: profiles.

    z(theta) = sum_n z_n P_n0,   rho(theta) = sum_n rho_n P_n1   (the distance from the axis);

a profile is the array [2, M] of z_n (row 0) and rho_n (row 1, rho_0 = 0). Its entries are amounts
of the members of `axisymmetric_basis`.
"""

import math
from collections.abc import Callable

import numpy as np
from jaxtyping import Float

from celltrain.harmonics.legendre import legendre_functions
from celltrain.harmonics.nodes import gauss_colatitudes
from celltrain.harmonics.shapes import Shape, degree_of

Profile = Float[np.ndarray, "2 degree"]
Angles = Float[np.ndarray, " point"]
Meridian = tuple[Float[np.ndarray, " point"], Float[np.ndarray, " point"]]


def profile_of(coefficients: Shape) -> Profile:
    """The profile of a shape's axisymmetric part: z, and x on the half plane y = 0."""
    n = np.arange(degree_of(coefficients))
    profile = np.zeros((2, n.size))
    profile[0] = coefficients[2, n * n + n]
    profile[1, 1:] = math.sqrt(2.0) * coefficients[0, (n * n + n + 1)[1:]]
    return profile


def coefficients_of(profile: Profile) -> Shape:
    """The harmonic coefficients [3, M^2] of an axisymmetric shape."""
    n = np.arange(profile.shape[1])
    coefficients = np.zeros((3, n.size**2))
    place = n * n + n
    coefficients[2, place] = profile[0]
    coefficients[0, place[1:] + 1] = coefficients[1, place[1:] - 1] = (
        math.sqrt(0.5) * profile[1, 1:]
    )
    return coefficients


def project_meridian(degree: int, meridian: Callable[[Angles], Meridian], order: int) -> Profile:
    """The profile, below a degree, nearest to a meridian (rho, z) given as a function of theta.

    **Arguments:** `order`: of the Gauss-Legendre rule in theta.
    """
    theta, weights = gauss_colatitudes(order)
    legendre = legendre_functions(degree, 1, theta)
    rho, z = meridian(theta)
    around = 2.0 * math.pi * weights
    return np.stack([legendre[0] @ (around * z), legendre[1] @ (around * rho)])
