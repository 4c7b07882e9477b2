"""Surfaces given by harmonic coefficients, in JAX: derivatives, normals, areas, volumes."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from celltrain.harmonics.grid import sphere_grid
from celltrain.harmonics.jax_shapes import JaxShape
from celltrain.harmonics.tables import HarmonicTables, harmonic_tables
from celltrain.membrane.density import Forms
from celltrain.membrane.forms import fundamental_forms
from celltrain.runtime import constant


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


class VolumeRule(eqx.Module):
    """Volumes (1/3) int x . (x_theta x x_phi)/sin(theta) dOmega of shapes of one degree.

    The integrand is a polynomial of degree at most 3 M - 3 on the sphere, so that the grid of order
    3 M/2 integrates it exactly. Harmonics and their derivatives are there as in `HarmonicTables`.
    """

    value: Float[Array, "point coefficient"]
    d_theta: Float[Array, "point coefficient"]
    d_phi: Float[Array, "point coefficient"]
    weights: Float[Array, " point"]

    def volume(self, coefficients: JaxShape) -> Float[Array, ""]:
        """Enclosed volume, in r0^3."""
        cross = jnp.cross(self.d_theta @ coefficients.T, self.d_phi @ coefficients.T)
        return jnp.sum(self.weights * jnp.sum((self.value @ coefficients.T) * cross, axis=-1))


def volume_rule(degree: int) -> VolumeRule:
    """The rule for shapes of a degree."""
    grid = sphere_grid(1, -(-3 * degree // 2))
    theta, phi = grid.points()
    tables = harmonic_tables(degree, theta, phi)
    weights = constant(np.asarray(grid.weights) / (3.0 * np.sin(theta)))
    return VolumeRule(tables.value, tables.d_theta, tables.d_phi, weights)
