"""Real orthonormal spherical harmonics, in NumPy.

    Y_nm(theta, phi) = P_n|m|(theta) * (sqrt(2) cos(m phi)   m > 0
                                        1                    m = 0
                                        sqrt(2) sin(|m| phi) m < 0),

with P_nm the associated Legendre functions of `legendre`. Those of degree n < M are stored along
one axis of length M^2, the harmonic (n, m) at n^2 + n + m.
"""

import math

import numpy as np
from jaxtyping import Float, Int

from celltrain.harmonics.legendre import legendre_functions


def coefficient_index(degree: int, order: int) -> int:
    """Place of the harmonic of degree n and order m (negative: sine) along the last axis."""
    return degree * degree + degree + order


def degrees_and_orders(
    degree: int,
) -> tuple[Int[np.ndarray, " coefficient"], Int[np.ndarray, " coefficient"]]:
    """Degree n and order m of each of the M^2 coefficients below degree M."""
    n = np.repeat(np.arange(degree), 2 * np.arange(degree) + 1)
    return n, np.arange(degree * degree) - n * n - n


def longitude_factors(
    order: Int[np.ndarray, " coefficient"], phi: Float[np.ndarray, " point"]
) -> tuple[np.ndarray, np.ndarray]:
    """Longitude factor of each harmonic and its derivative, [coefficient, point]."""
    m = np.abs(order)
    turn = np.arange(m.max() + 1)[:, None] * phi
    scale = np.where(m > 0, math.sqrt(2.0), 1.0)[:, None]
    cosine, sine, m = scale * np.cos(turn)[m], scale * np.sin(turn)[m], m[:, None]
    is_sine = (order < 0)[:, None]
    return np.where(is_sine, sine, cosine), np.where(is_sine, m * cosine, -m * sine)


def real_harmonics(
    degree: int, theta: Float[np.ndarray, " point"], phi: Float[np.ndarray, " point"]
) -> Float[np.ndarray, "point coefficient"]:
    """Values of all harmonics below `degree` at the given colatitudes and longitudes."""
    n, order = degrees_and_orders(degree)
    legendre = legendre_functions(degree, degree - 1, np.asarray(theta, dtype=float))
    longitude, _ = longitude_factors(order, np.asarray(phi, dtype=float))
    return (legendre[np.abs(order), n] * longitude).T
