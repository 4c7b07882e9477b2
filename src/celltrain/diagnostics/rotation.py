"""How a cell turns: as a rigid body (tumbling), and its membrane around it (tank-treading).

Eqs. (17)-(21) of Bryngelson & Freund (2018). The axes e of the cell are the eigenvectors of the
shell tensor M, Eq. (18), and e' = omega x e, Eq. (17), gives

    (3 I - sum_i e_i e_i) . omega = sum_i e_i x e_i',                                   Eq. (19)

whose matrix is 2 I. With M' = dM/dt, component k of omega along the axes is
e_j.M'.e_i/(lambda_i - lambda_j), (i, j, k) cyclic. The membrane's own rotation Omega solves

    R . Omega = int x x v dS,   R = A (I tr M - M),                                Eqs. (20), (21)

x and v relative to the centroid and its velocity. The paper prints v x x, which would turn a rigid
body backwards; x x v is meant, since then Omega = omega for a rigid motion. Tumbling is |omega|,
tank-treading |Omega - omega|.

Where two eigenvalues coincide, as in every axisymmetric cell, the axes do not define the rotation
about the third: M then says nothing. There the membrane's own rotation is taken instead, so that
turning about an axis of symmetry is no tank-treading; with g the difference of the eigenvalues over
their sum and G = `COINCIDENT`, the two have the weights g^4/(g^4 + G^4) and G^4/(g^4 + G^4): the
paper's omega to 1e-8 where g > 0.1. A rigid motion is exact whatever G.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from celltrain.diagnostics.modes import COINCIDENT
from celltrain.diagnostics.moments import CellMoments, cell_moments, surface_elements
from celltrain.harmonics.jax_shapes import JaxShape
from celltrain.membrane.energy import Membrane


class CellMotion(eqx.Module):
    """A cell's motion: velocity of its centroid (U), omega and Omega (U/r0)."""

    centroid_velocity: Float[Array, "3"]
    rotation_rate: Float[Array, "3"]
    membrane_rotation_rate: Float[Array, "3"]

    @property
    def tumbling(self) -> Float[Array, ""]:
        """|omega|, in U/r0."""
        return jnp.linalg.norm(self.rotation_rate)

    @property
    def tank_treading(self) -> Float[Array, ""]:
        """|Omega - omega|, in U/r0."""
        return jnp.linalg.norm(self.membrane_rotation_rate - self.rotation_rate)


def cell_motion(
    membrane: Membrane,
    shape: JaxShape,
    rates: JaxShape,
) -> CellMotion:
    """Motion of a cell whose coefficients change at the given rates (U).

    The velocity is relative to the frame of the rates; it and M' are exact derivatives.
    """
    moments, change = jax.jvp(lambda s: cell_moments(membrane, s), (shape,), (rates,))
    rotation = membrane_rotation(membrane, shape, rates, moments, change.centroid)
    return CellMotion(
        change.centroid, axes_rotation(moments.shell, change.shell, rotation), rotation
    )


def membrane_rotation(
    membrane: Membrane,
    shape: JaxShape,
    rates: JaxShape,
    moments: CellMoments,
    centroid_velocity: Float[Array, "3"],
) -> Float[Array, "3"]:
    """Omega of Eqs. (20) and (21), in U/r0."""
    points, elements = surface_elements(membrane, shape)
    velocity = membrane.tables.value @ rates.T - centroid_velocity
    area = jnp.linalg.norm(elements, axis=1)
    turning = jnp.sum(jnp.cross(points - moments.centroid, velocity) * area[:, None], axis=0)
    tensor = moments.area * (jnp.eye(3) * jnp.trace(moments.shell) - moments.shell)
    return jnp.linalg.solve(tensor, turning)


def axes_rotation(
    tensor: Float[Array, "3 3"], change: Float[Array, "3 3"], rotation: Float[Array, "3"]
) -> Float[Array, "3"]:
    """omega of Eq. (19) from M and dM/dt, in U/r0.

    **Arguments:** `rotation`: Omega, taken along an axis about which M is symmetric.
    """
    values, axes = jnp.linalg.eigh(tensor)
    axes = axes * jnp.array([1.0, 1.0, jnp.linalg.det(axes)])
    following, last = jnp.array([1, 2, 0]), jnp.array([2, 0, 1])
    scale = jnp.sum(values)
    spread = (values[following] - values[last]) / scale
    turning = (axes.T @ change @ axes)[last, following] / scale
    along = (spread**3 * turning + COINCIDENT**4 * (axes.T @ rotation)) / (
        spread**4 + COINCIDENT**4
    )
    return axes @ along
