"""What cells add to the stress of the fluid in which they are suspended."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from celltrain.diagnostics.moments import surface_elements
from celltrain.harmonics import surface_points
from celltrain.harmonics.jax_shapes import JaxShapes
from celltrain.programs import Program
from celltrain.train import CellsOperator


@Program
def stresslets(
    operator: CellsOperator, shapes: JaxShapes, forces: JaxShapes, motions: JaxShapes
) -> Float[Array, "cell 3 3"]:
    """The stresslet of each cell, in mu U r0^2 (Batchelor 1970).

    With F the force on the fluid per solid angle, u the velocity of the membrane, lam the viscosity
    ratio and n outward, it is the symmetric part without trace of

        S_ij = -int x_i F_j dOmega + (lam - 1) int (u_i n_j + n_i u_j) dS,   x from the mean point.

    Its sum over the cells in a volume, divided by that volume, is their part of the mean stress. A
    rigid sphere in the rate of strain E has 20 pi/3 E.

    **Arguments:** `forces`: such as `operator.forces(shapes)`; `motions`: rates of the shapes.
    """
    # Harmonics are orthonormal: sums over coefficients are integrals over the parameter sphere.
    centred = shapes.at[..., 0].set(0.0)
    moment = -jnp.einsum("cik,cjk->cij", centred, forces)
    if operator.viscosity_ratio is not None:
        values = operator.membrane.tables.value

        def rate_of_strain(shape: Array, motion: Array) -> Float[Array, "3 3"]:
            _, elements = surface_elements(operator.membrane, shape)
            dyad = surface_points(motion, values).T @ elements
            return dyad + dyad.T

        strained = jax.vmap(rate_of_strain)(shapes, motions)
        moment += (operator.viscosity_ratio - 1.0) * strained
    symmetric = 0.5 * (moment + jnp.swapaxes(moment, 1, 2))
    trace = jnp.trace(symmetric, axis1=1, axis2=2)[:, None, None]
    return symmetric - trace / 3.0 * jnp.eye(3)
