"""Elastic energy of a cell and the force that its membrane exerts on the fluid.

    E = int [ W(I1, I2) + B(kappa, kappa_ref) ] dA_ref,   kappa = a^-1 b,

with W that of a constitutive law (`laws`) and B that of bending (`bending`).

The force per unit of solid angle has the harmonic coefficients F_c = -dE/ds_c exactly, because the
harmonics are orthonormal. No surface Jacobian and no third derivative appears, and the net force
and torque vanish because E is invariant under rigid motions.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from celltrain.harmonics.grid import sphere_grid
from celltrain.harmonics.tables import HarmonicTables, harmonic_tables
from celltrain.membrane.bending import BendingLaw, Mixed
from celltrain.membrane.geometry import SurfaceGeometry, surface_geometry, volume
from celltrain.membrane.laws import ConstitutiveLaw


def _mixed(metric: tuple[Array, Array, Array], form: tuple[Array, Array, Array]) -> Mixed:
    """Components (11, 12, 21, 22) of metric^-1 form for symmetric 2 x 2 tensors."""
    a, b, c = metric
    p, q, r = form
    determinant = a * c - b * b
    return (
        (c * p - b * q) / determinant,
        (c * q - b * r) / determinant,
        (a * q - b * p) / determinant,
        (a * r - b * q) / determinant,
    )


class Membrane(eqx.Module):
    """A membrane with its constitutive law, bending energy and resting shape.

    The grid of `tables` is finer than the shape's degree (three times, as in the paper), because
    the energy density is not band-limited.
    """

    law: ConstitutiveLaw
    bending: BendingLaw
    tables: HarmonicTables
    weights: Float[Array, " point"]
    inverse_sine: Float[Array, " point"]
    reference: SurfaceGeometry
    reference_shape: Float[Array, "3 coefficient"]

    def energy(self, coefficients: Float[Array, "3 coefficient"]) -> Float[Array, ""]:
        """Elastic energy of one cell, in mu U r0^2."""
        deformed = surface_geometry(self.tables, coefficients)
        in_plane = self.law.energy_density(*self.invariants(deformed))
        now = _mixed(deformed.metric, deformed.curvature)
        rest = _mixed(self.reference.metric, self.reference.curvature)
        bending = self.bending.energy_density(now, rest, deformed.area / self.reference.area)
        area = self.reference.area * self.inverse_sine * self.weights
        return jnp.sum((in_plane + bending) * area)

    def invariants(
        self, deformed: SurfaceGeometry
    ) -> tuple[Float[Array, " point"], Float[Array, " point"]]:
        """Strain invariants I1 = tr(C) - 2 and I2 = det(C) - 1 of a surface on the grid."""
        c11, c12, c21, c22 = _mixed(self.reference.metric, deformed.metric)
        return c11 + c22 - 2.0, c11 * c22 - c12 * c21 - 1.0

    def force(self, coefficients: Float[Array, "3 coefficient"]) -> Float[Array, "3 coefficient"]:
        """Coefficients of the force per solid angle on the fluid, F = -dE/ds, in mu U r0."""
        return -jax.grad(self.energy)(coefficients)

    def volume(self, coefficients: Float[Array, "3 coefficient"]) -> Float[Array, ""]:
        """Enclosed volume, in r0^3."""
        return volume(self.tables, self.weights, self.inverse_sine, coefficients)

    def volume_gradient(
        self, coefficients: Float[Array, "3 coefficient"]
    ) -> Float[Array, "3 coefficient"]:
        """dV/ds: the coefficients of n dS/dOmega, in r0^2."""
        return jax.grad(self.volume)(coefficients)


def make_membrane(
    law: ConstitutiveLaw,
    bending: BendingLaw,
    reference_shape: Float[np.ndarray, "3 coefficient"],
    *,
    energy_order: int,
) -> Membrane:
    """Membrane that is free of stress in `reference_shape`, but for what its bending energy adds.

    **Arguments:** `energy_order`: rings of the grid on which the energy is integrated; 3 M is the
    paper's choice.
    """
    degree = int(np.sqrt(reference_shape.shape[-1]))
    grid = sphere_grid(1, energy_order)
    theta, phi = grid.points()
    tables = harmonic_tables(degree, theta, phi)
    return Membrane(
        law=law,
        bending=bending,
        tables=tables,
        weights=grid.weights,
        inverse_sine=jnp.asarray(1.0 / np.sin(theta)),
        reference=eqx.filter_jit(surface_geometry)(tables, jnp.asarray(reference_shape)),
        reference_shape=jnp.asarray(reference_shape),
    )
