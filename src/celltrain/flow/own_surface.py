"""Velocity on a surface by the singular near kernel of its own force.

For each target the surface is integrated in polar coordinates about it, where the area element
cancels the kernel's 1/r. Targets are the points of a product grid; those of one ring share one
matrix of harmonics at their nodes, since shifting the coefficients in longitude brings each of them
to phi = 0.
"""

import math

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from celltrain.flow.ewald import near_scalars
from celltrain.harmonics import polar_rule, real_harmonics, shift_longitude


class OwnSurfaceRule(eqx.Module):
    """Polar quadrature about the rings of a target grid."""

    parameter: float = eqx.field(static=True)
    nodes: Float[Array, "ring node coefficient"]
    weights: Float[Array, " node"]

    def velocity(
        self,
        targets: Float[Array, "cell ring azimuth 3"],
        longitudes: Float[Array, " azimuth"],
        shapes: Float[Array, "cell 3 coefficient"],
        forces: Float[Array, "cell 3 coefficient"],
    ) -> Float[Array, "cell ring azimuth 3"]:
        """(1/8 pi) int G_near F dOmega over each target's own cell.

        **Arguments:** `longitudes`: of the targets on the parameter sphere; `forces`: coefficients
        of the force per solid angle.
        """
        both = jnp.concatenate([shapes, forces], axis=1)
        shifted = shift_longitude(both, longitudes)

        def of_ring(ring: tuple[Array, Array]) -> Float[Array, "cell azimuth 3"]:
            matrix, points = ring
            values = jnp.einsum("nk,acik->ican", matrix, shifted)
            d = [points[..., i, None] - values[i] for i in range(3)]
            force = values[3:] * self.weights
            isotropic, dyadic = near_scalars(d[0] ** 2 + d[1] ** 2 + d[2] ** 2, self.parameter)
            along = dyadic * (d[0] * force[0] + d[1] * force[1] + d[2] * force[2])
            parts = [jnp.sum(isotropic * force[i] + d[i] * along, axis=-1) for i in range(3)]
            return jnp.stack(parts, axis=-1)

        by_ring = jax.lax.map(of_ring, (self.nodes, jnp.moveaxis(targets, 1, 0)))
        return jnp.moveaxis(by_ring, 0, 1) / (8.0 * math.pi)


def own_surface_rule(
    degree: int, theta: Float[np.ndarray, " ring"], *, radial: int, azimuthal: int, parameter: float
) -> OwnSurfaceRule:
    """Rule with `radial` x `azimuthal` nodes about each ring's target at phi = 0."""
    matrices, weights = [], np.empty(0)
    for each in theta:
        node_theta, node_phi, weights = polar_rule(float(each), radial, azimuthal)
        matrices.append(real_harmonics(degree, node_theta, node_phi))
    return OwnSurfaceRule(parameter, jnp.asarray(np.stack(matrices)), jnp.asarray(weights))
