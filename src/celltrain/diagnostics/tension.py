"""Isotropic tension of the membrane."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from celltrain.harmonics.jax_shapes import JaxShape
from celltrain.membrane.energy import Membrane


def isotropic_tension(membrane: Membrane, shape: JaxShape) -> Float[Array, " point"]:
    """Mean of the two principal tensions at the points of the membrane's grid, in mu U.

    A membrane with the energy W(I1, I2) for each area at rest has the principal tensions
    t1 = (1/l2) dW/dl1 and t2 = (1/l1) dW/dl2, l1 and l2 its principal stretches; so

        (t1 + t2)/2 = [(I1 + 2) W_1 + 2 (I2 + 1) W_2]/sqrt(I2 + 1),

    subscripts of W being derivatives (*Barthes-Biesel, Diaz & Dhenin 2002*). Bending adds nothing.
    """
    first, second = membrane.invariants(shape)

    def energy(first: Float[Array, ""], second: Float[Array, ""]) -> Float[Array, ""]:
        return membrane.law.energy_density(first, second)

    by_first, by_second = jax.vmap(jax.grad(energy, argnums=(0, 1)))(first, second)
    return ((first + 2.0) * by_first + 2.0 * (second + 1.0) * by_second) / jnp.sqrt(second + 1.0)
