"""Real orthonormal spherical harmonics and their derivatives.

    Y_nm(theta, phi) = P_n|m|(theta) * (sqrt(2) cos(m phi)   m > 0
                                        1                    m = 0
                                        sqrt(2) sin(|m| phi) m < 0),

with P_nm the associated Legendre functions without the Condon-Shortley sign, scaled such that the
harmonics are orthonormal on the unit sphere. Those of degree n < M are stored along one axis of
length M^2, the harmonic (n, m) at n^2 + n + m.
"""

import math

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

import celltrain.runtime  # noqa: F401


def coefficient_index(degree: int, order: int) -> int:
    """Place of the harmonic of degree n and order m (negative: sine) along the last axis."""
    return degree * degree + degree + order


def degrees_and_orders(
    degree: int,
) -> tuple[Int[np.ndarray, " coefficient"], Int[np.ndarray, " coefficient"]]:
    """Degree n and order m of each of the M^2 coefficients below degree M."""
    n = np.repeat(np.arange(degree), 2 * np.arange(degree) + 1)
    return n, np.arange(degree * degree) - n * n - n


def _legendre(
    degree: int, theta: Float[np.ndarray, " point"]
) -> Float[np.ndarray, "degree degree point"]:
    """Normalised Legendre functions P[n, m] by the stable recursion in n."""
    cosine, sine = np.cos(theta), np.sin(theta)
    values = np.zeros((degree, degree, theta.size))
    values[0, 0] = math.sqrt(0.25 / math.pi)
    for m in range(1, degree):
        values[m, m] = math.sqrt((2 * m + 1) / (2 * m)) * sine * values[m - 1, m - 1]
    for m in range(degree):
        for n in range(m + 1, degree):
            scale = math.sqrt((4 * n * n - 1) / (n * n - m * m))
            values[n, m] = scale * cosine * values[n - 1, m]
            if n > m + 1:
                previous = math.sqrt(((n - 1) ** 2 - m * m) / (4 * (n - 1) ** 2 - 1))
                values[n, m] -= scale * previous * values[n - 2, m]
    return values


def _legendre_slope(
    values: Float[np.ndarray, "degree degree point"],
) -> Float[np.ndarray, "degree degree point"]:
    """d/dtheta of the normalised Legendre functions, from their neighbours in m."""
    degree = values.shape[0]
    slope = np.zeros_like(values)
    for n in range(degree):
        for m in range(n + 1):
            above = math.sqrt((n - m) * (n + m + 1)) * values[n, m + 1] if m < n else 0.0
            if m == 0:
                slope[n, m] = -above
            else:
                slope[n, m] = 0.5 * (math.sqrt((n + m) * (n - m + 1)) * values[n, m - 1] - above)
    return slope


def _longitudes(
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
    legendre = _legendre(degree, np.asarray(theta, dtype=float))[n, np.abs(order)]
    longitude, _ = _longitudes(order, np.asarray(phi, dtype=float))
    return (legendre * longitude).T


class HarmonicTables(eqx.Module):
    """Values and derivatives of the harmonics at fixed points, each [point, coefficient]."""

    value: Float[Array, "point coefficient"]
    d_theta: Float[Array, "point coefficient"]
    d_phi: Float[Array, "point coefficient"]
    d_theta_theta: Float[Array, "point coefficient"]
    d_theta_phi: Float[Array, "point coefficient"]
    d_phi_phi: Float[Array, "point coefficient"]


def harmonic_tables(
    degree: int, theta: Float[np.ndarray, " point"], phi: Float[np.ndarray, " point"]
) -> HarmonicTables:
    """Harmonics and their first and second derivatives; no point may lie on a pole.

    The second derivative in theta follows from Legendre's equation,
    P'' = -cot(theta) P' - (n (n + 1) - m^2/sin^2(theta)) P.
    """
    n, order = degrees_and_orders(degree)
    m = np.abs(order)
    all_values = _legendre(degree, theta)
    legendre = all_values[n, m]
    slope = _legendre_slope(all_values)[n, m]
    level = (n * (n + 1))[:, None] - (m * m)[:, None] / np.sin(theta) ** 2
    curvature = -slope / np.tan(theta) - level * legendre
    longitude, longitude_slope = _longitudes(order, phi)
    columns = {
        "value": legendre * longitude,
        "d_theta": slope * longitude,
        "d_phi": legendre * longitude_slope,
        "d_theta_theta": curvature * longitude,
        "d_theta_phi": slope * longitude_slope,
        "d_phi_phi": -((m * m)[:, None]) * legendre * longitude,
    }
    return HarmonicTables(**{name: jnp.asarray(array.T) for name, array in columns.items()})


def turns(
    angles: Float[Array, " angle"], degree: int
) -> tuple[Float[Array, "angle coefficient"], Float[Array, "angle coefficient"]]:
    """cos(m a) and sin(m a) for every coefficient's order m, negative for the sines."""
    _, order = degrees_and_orders(degree)
    turn = angles[:, None] * jnp.arange(degree)
    # By a matrix that puts each order in its places: what XLA can merge with the cosines it
    # computes anew for each coefficient and each function.
    places = np.abs(order) == np.arange(degree)[:, None]
    return jnp.cos(turn) @ places.astype(float), jnp.sin(turn) @ (places * np.sign(order))


def partners(
    coefficients: Float[Array, "*batch coefficient"],
) -> Float[Array, "*batch coefficient"]:
    """The coefficients of opposite order, cosines for sines."""
    n, order = degrees_and_orders(math.isqrt(coefficients.shape[-1]))
    return coefficients[..., n * n + n - order]


def shift_longitude(
    coefficients: Float[Array, "*batch coefficient"], angles: Float[Array, " angle"]
) -> Float[Array, "angle *batch coefficient"]:
    """Coefficients of x(theta, phi + angle), for each angle."""
    # cos(m (phi + a)) = cos(m a) cos(m phi) - sin(m a) sin(m phi), and the like for the sine.
    shape = (-1,) + (1,) * (coefficients.ndim - 1) + coefficients.shape[-1:]
    found = turns(angles, math.isqrt(coefficients.shape[-1]))
    cosine, sine = (each.reshape(shape) for each in found)
    return cosine * coefficients + sine * partners(coefficients)


def unshift_longitude(
    functionals: Float[Array, "*batch angle coefficient"], angles: Float[Array, " angle"]
) -> Float[Array, "*batch angle coefficient"]:
    """Transpose of `shift_longitude`: what acts on x(theta, phi + angle), as acting on x."""
    cosine, sine = turns(angles, math.isqrt(functionals.shape[-1]))
    return cosine * functionals - sine * partners(functionals)
