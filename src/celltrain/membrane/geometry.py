"""Differential geometry of a surface given by harmonic coefficients."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from celltrain.harmonics.tables import HarmonicTables


class SurfaceGeometry(eqx.Module):
    """Fundamental forms at the points of a grid, in the coordinates (theta, phi).

    `metric` a_ij = x_i . x_j; `curvature` b_ij = n . x_ij; `normal` is outward; `area` is
    sqrt(det a) = dS/(dtheta dphi).
    """

    position: Float[Array, "point 3"]
    normal: Float[Array, "point 3"]
    area: Float[Array, " point"]
    metric: tuple[Float[Array, " point"], Float[Array, " point"], Float[Array, " point"]]
    curvature: tuple[Float[Array, " point"], Float[Array, " point"], Float[Array, " point"]]


def surface_geometry(
    tables: HarmonicTables, coefficients: Float[Array, "3 coefficient"]
) -> SurfaceGeometry:
    """Fundamental forms (theta-theta, theta-phi, phi-phi) of x = sum_c s_c Y_c."""
    x_theta = tables.d_theta @ coefficients.T
    x_phi = tables.d_phi @ coefficients.T
    cross = jnp.cross(x_theta, x_phi)
    area = jnp.sqrt(jnp.sum(cross * cross, axis=-1))
    normal = cross / area[:, None]

    def along_normal(table: Float[Array, "point coefficient"]) -> Float[Array, " point"]:
        return jnp.sum((table @ coefficients.T) * normal, axis=-1)

    return SurfaceGeometry(
        position=tables.value @ coefficients.T,
        normal=normal,
        area=area,
        metric=(
            jnp.sum(x_theta * x_theta, axis=-1),
            jnp.sum(x_theta * x_phi, axis=-1),
            jnp.sum(x_phi * x_phi, axis=-1),
        ),
        curvature=(
            along_normal(tables.d_theta_theta),
            along_normal(tables.d_theta_phi),
            along_normal(tables.d_phi_phi),
        ),
    )


def volume(
    tables: HarmonicTables,
    weights: Float[Array, " point"],
    inverse_sine: Float[Array, " point"],
    coefficients: Float[Array, "3 coefficient"],
) -> Float[Array, ""]:
    """Enclosed volume (1/3) int x . (x_theta x x_phi)/sin(theta) dOmega.

    The integrand is a polynomial of degree at most 3 M - 3 on the sphere, so a grid of order
    3 M / 2 integrates it exactly.
    """
    cross = jnp.cross(tables.d_theta @ coefficients.T, tables.d_phi @ coefficients.T)
    density = jnp.sum((tables.value @ coefficients.T) * cross, axis=-1) * inverse_sine
    return jnp.sum(weights * density) / 3.0
