"""What lives on the membranes at one time, for pictures: velocity and isotropic tension."""

import equinox as eqx
import jax
from jaxtyping import Array, Float

from celltrain.diagnostics.tension import isotropic_tension
from celltrain.harmonics import surface_points
from celltrain.harmonics.jax_shapes import JaxShapes
from celltrain.membrane.energy import Membrane
from celltrain.programs import Program


class SurfaceFields(eqx.Module):
    """Points of the membrane's grid, by ring: position in r0, velocity in U, tension in mu U."""

    position: Float[Array, "cell point 3"]
    velocity: Float[Array, "cell point 3"]
    tension: Float[Array, "cell point"]


@Program
def surface_fields(
    membrane: Membrane,
    shapes: JaxShapes,
    rates: JaxShapes,
) -> SurfaceFields:
    """Position, velocity and tension at the points on which the energy is integrated.

    The velocity is u = sum_c (ds_c/dt) Y_c, in the frame of the rates; the tension is the mean of
    the principal ones (see `isotropic_tension`).
    """
    values = membrane.tables.value
    return SurfaceFields(
        position=surface_points(shapes, values),
        velocity=surface_points(rates, values),
        tension=jax.vmap(lambda shape: isotropic_tension(membrane, shape))(shapes),
    )
