"""The harmonics and their derivatives at fixed points, as matrices of JAX."""

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from celltrain.harmonics.basis import degrees_and_orders, longitude_factors
from celltrain.harmonics.legendre import legendre_tables
from celltrain.runtime import constant


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
    """Harmonics and their first and second derivatives; no point may lie on a pole."""
    n, order = degrees_and_orders(degree)
    m = np.abs(order)
    legendre = legendre_tables(degree, degree - 1, theta)
    value, slope, curvature = (
        each[m, n] for each in (legendre.value, legendre.slope, legendre.curvature)
    )
    longitude, longitude_slope = longitude_factors(order, phi)
    columns = {
        "value": value * longitude,
        "d_theta": slope * longitude,
        "d_phi": value * longitude_slope,
        "d_theta_theta": curvature * longitude,
        "d_theta_phi": slope * longitude_slope,
        "d_phi_phi": -((m * m)[:, None]) * value * longitude,
    }
    return HarmonicTables(**{name: constant(array.T) for name, array in columns.items()})
