"""Surfaces given by harmonic coefficients, in JAX: derivatives, normals, areas, volumes."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from celltrain.harmonics.jax_shapes import JaxShape
from celltrain.harmonics.tables import HarmonicTables
from celltrain.membrane.density import Forms
from celltrain.membrane.forms import fundamental_forms


class SurfaceGeometry(eqx.Module):
    """Position, outward normal and area element at the points of a grid.

    `area` is |x_theta x x_phi| = dS/(dtheta dphi).
    """

    position: Float[Array, "point 3"]
    normal: Float[Array, "point 3"]
    area: Float[Array, " point"]


def surface_geometry(tables: HarmonicTables, coefficients: JaxShape) -> SurfaceGeometry:
    """Geometry of x = sum_c s_c Y_c."""
    cross = jnp.cross(tables.d_theta @ coefficients.T, tables.d_phi @ coefficients.T)
    area = jnp.sqrt(jnp.sum(cross * cross, axis=-1))
    return SurfaceGeometry(tables.value @ coefficients.T, cross / area[:, None], area)


def surface_forms(tables: HarmonicTables, coefficients: JaxShape) -> Forms:
    """The metric, and the curvature form times sqrt(det a), at the points of a grid."""
    derivatives = (
        tables.d_theta,
        tables.d_phi,
        tables.d_theta_theta,
        tables.d_theta_phi,
        tables.d_phi_phi,
    )
    return fundamental_forms([coefficients @ table.T for table in derivatives])


def volume(
    tables: HarmonicTables,
    weights: Float[Array, " point"],
    inverse_sine: Float[Array, " point"],
    coefficients: JaxShape,
) -> Float[Array, ""]:
    """Enclosed volume (1/3) int x . (x_theta x x_phi)/sin(theta) dOmega.

    The integrand is a polynomial of degree at most 3 M - 3 on the sphere, so a grid of order
    3 M / 2 integrates it exactly.
    """
    cross = jnp.cross(tables.d_theta @ coefficients.T, tables.d_phi @ coefficients.T)
    density = jnp.sum((tables.value @ coefficients.T) * cross, axis=-1) * inverse_sine
    return jnp.sum(weights * density) / 3.0
