"""Elastic energy of a cell of any shape, and the force that its membrane exerts, in JAX.

    E = int [ W(I1, I2) + B(kappa, kappa_ref) ] dA_ref,   kappa = a^-1 b,

with W that of a constitutive law and B that of bending (see `laws`), put together in `density`.
Bending moments have no energy; their force is found from the work that they do.

The force per unit of solid angle has the harmonic coefficients F_c = -dE/ds_c exactly, because the
harmonics are orthonormal. No surface Jacobian and no third derivative appears, and the net force
and torque vanish because E, and the metric and curvature that moments work on, are invariant under
rigid motions.
"""

from dataclasses import fields
from typing import Any, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

import celltrain.runtime  # noqa: F401
from celltrain.harmonics import Shape, degree_of
from celltrain.harmonics.grid import sphere_grid
from celltrain.harmonics.jax_shapes import JaxShape
from celltrain.harmonics.tables import HarmonicTables, harmonic_tables
from celltrain.laws.bending import BENDINGS, BendingLaw, MomentBending
from celltrain.laws.constitutive import LAWS, ConstitutiveLaw
from celltrain.membrane.density import (
    RestGeometry,
    energy_density,
    in_plane_density,
    invariants,
    moment_work,
    rest_geometry,
)
from celltrain.membrane.geometry import VolumeRule, surface_forms, volume_rule
from celltrain.programs import Program
from celltrain.runtime import constant

_Law = TypeVar("_Law", ConstitutiveLaw, BendingLaw)


def _register(kind: Any) -> None:
    """Make a law's moduli leaves: other values compile nothing anew, and have derivatives.

    With the kind as data of the node. JAX takes registered dataclasses with the same fields for the
    same (0.10.1), and would use what is compiled for one law for another.
    """
    names = [field.name for field in fields(kind)]
    jax.tree_util.register_pytree_node(
        kind,
        lambda law: (tuple(getattr(law, name) for name in names), kind),
        lambda _, moduli: kind(*moduli),
    )


for _kind in (*LAWS.values(), *BENDINGS.values()):
    _register(_kind)


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
    volume_rule: VolumeRule
    reference: RestGeometry
    reference_shape: JaxShape

    def energy(self, coefficients: JaxShape) -> Float[Array, ""]:
        """Elastic energy of one cell, in mu U r0^2.

        **Raises:** `CaseError` for bending moments, which have none.
        """
        forms = surface_forms(self.tables, coefficients)
        density = energy_density(self.law, self.bending, forms, self.reference)
        return jnp.sum(density * self._rest_weights)

    def in_plane_energy(self, coefficients: JaxShape) -> Float[Array, ""]:
        """Elastic energy of one cell without bending, in mu U r0^2."""
        forms = surface_forms(self.tables, coefficients)
        density = in_plane_density(self.law, forms, self.reference)
        return jnp.sum(density * self._rest_weights)

    def invariants(
        self, coefficients: JaxShape
    ) -> tuple[Float[Array, " point"], Float[Array, " point"]]:
        """Strain invariants I1 = tr(C) - 2 and I2 = det(C) - 1 of a shape, on the grid."""
        return invariants(surface_forms(self.tables, coefficients), self.reference)

    def force(self, coefficients: JaxShape) -> JaxShape:
        """Coefficients of the force per solid angle on the fluid, F = -dE/ds, in mu U r0.

        With bending moments what they do is in the place of the derivatives of their energy.
        """
        if not isinstance(self.bending, MomentBending):
            return -jax.grad(self.energy)(coefficients)
        forms, along = jax.vjp(lambda shape: surface_forms(self.tables, shape), coefficients)
        work = moment_work(self.bending, forms, self.reference)
        [bent] = along(jax.tree.map(lambda each: each * self._rest_weights, work.forms))
        if not self.bending.BALANCED:
            turning = work.turning * self._rest_weights
            by_theta, by_phi = self.tables.d_theta, self.tables.d_phi
            bent += (coefficients @ by_theta.T * turning) @ by_phi
            bent -= (coefficients @ by_phi.T * turning) @ by_theta
        return -jax.grad(self.in_plane_energy)(coefficients) - bent

    @property
    def _rest_weights(self) -> Float[Array, " point"]:
        """Reference area of each point."""
        return self.reference.area * self.inverse_sine * self.weights

    def volume(self, coefficients: JaxShape) -> Float[Array, ""]:
        """Enclosed volume, in r0^3."""
        return self.volume_rule.volume(coefficients)

    def volume_gradient(self, coefficients: JaxShape) -> JaxShape:
        """dV/ds: the coefficients of n dS/dOmega, in r0^2."""
        return jax.grad(self.volume)(coefficients)

    def at_rest_in(self, shape: JaxShape) -> "Membrane":
        """The same membrane with another resting shape."""
        return eqx.tree_at(
            lambda each: (each.reference, each.reference_shape),
            self,
            (_rest_geometry(self.tables, shape), shape),
        )


def make_membrane(
    law: ConstitutiveLaw,
    bending: BendingLaw,
    reference_shape: Shape,
    *,
    energy_order: int,
) -> Membrane:
    """Membrane that is free of stress in `reference_shape`, but for what its bending energy adds.

    **Arguments:** `energy_order`: rings of the grid on which the energy is integrated; 3 M is the
    paper's choice.
    """
    degree = degree_of(reference_shape)
    grid = sphere_grid(1, energy_order)
    theta, phi = grid.points()
    tables = harmonic_tables(degree, theta, phi)
    shape = jnp.asarray(reference_shape)
    return Membrane(
        law=_traceable(law),
        bending=_traceable(bending),
        tables=tables,
        weights=grid.weights,
        inverse_sine=constant(1.0 / np.sin(theta)),
        volume_rule=volume_rule(degree),
        reference=_rest_geometry(tables, shape),
        reference_shape=shape,
    )


@Program
def _rest_geometry(tables: HarmonicTables, shape: JaxShape) -> RestGeometry:
    return rest_geometry(surface_forms(tables, shape))


def _traceable(law: _Law) -> _Law:
    """With arrays for moduli."""
    return jax.tree.map(lambda modulus: constant(np.asarray(modulus, dtype=float)), law)
