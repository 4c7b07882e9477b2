"""Points of the unit sphere, and rules for integrals over it."""

import numpy as np
from jaxtyping import Float


def unit_vectors(
    theta: float | Float[np.ndarray, " *point"], phi: float | Float[np.ndarray, " *point"]
) -> Float[np.ndarray, "*point 3"]:
    """Points of the unit sphere at colatitudes and longitudes."""
    sine = np.sin(theta)
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), np.cos(theta)], axis=-1)


def gauss_colatitudes(
    order: int,
) -> tuple[Float[np.ndarray, " ring"], Float[np.ndarray, " ring"]]:
    """Gauss-Legendre colatitudes from pole to pole, and weights of int sin(theta) dtheta."""
    cosine, weights = np.polynomial.legendre.leggauss(order)
    return np.arccos(cosine)[::-1].copy(), weights[::-1].copy()


def about_pole(
    theta: float, alpha: Float[np.ndarray, " *point"], beta: Float[np.ndarray, " *point"]
) -> tuple[Float[np.ndarray, " *point"], Float[np.ndarray, " *point"]]:
    """Colatitude and longitude of points at the angle alpha from (theta, phi = 0).

    beta = 0 points away from the north pole, along phi = 0.
    """
    across, along, up = np.sin(alpha) * np.cos(beta), np.sin(alpha) * np.sin(beta), np.cos(alpha)
    x = np.cos(theta) * across + np.sin(theta) * up
    z = np.cos(theta) * up - np.sin(theta) * across
    return np.arctan2(np.hypot(x, along), z), np.arctan2(along, x)


def polar_nodes(
    radial: int, azimuthal: int
) -> tuple[
    Float[np.ndarray, " radial"],
    Float[np.ndarray, " azimuthal"],
    Float[np.ndarray, "radial azimuthal"],
]:
    """Polar angles about a point and weights of solid angle.

    The area element sin(alpha) dalpha dbeta cancels a singularity 1/alpha: Gauss-Legendre in alpha,
    uniform in beta (half a step off the plane of symmetry, so that the rule is symmetric and no
    node repeats).
    """
    nodes, gauss = np.polynomial.legendre.leggauss(radial)
    alpha = 0.5 * np.pi * (nodes + 1.0)
    beta = (np.arange(azimuthal) + 0.5) * 2.0 * np.pi / azimuthal
    weights = (0.5 * np.pi * gauss * np.sin(alpha))[:, None] * (2.0 * np.pi / azimuthal)
    return alpha, beta, np.repeat(weights, azimuthal, axis=1)
