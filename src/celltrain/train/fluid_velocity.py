"""Velocity of the fluid in a steady train."""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from celltrain.parameters import CaseError
from celltrain.programs import Program
from celltrain.steady import Base
from celltrain.surroundings import train_tube
from celltrain.train.operator import CellsOperator, train_operator

# Of a place on the wall, over the tube's radius.
ROUNDING = 1e-12


@Program
def _velocity(operator: CellsOperator, points: Array, shapes: Array) -> Array:
    return operator.velocity_at(points, shapes)


def fluid_velocity(
    base: Base, points: Float[np.ndarray, "point 3"]
) -> Float[np.ndarray, "point 3"]:
    """Velocity at points in the fluid or inside cells, in U and in the frame of the tube.

    **Arguments:** `points`: x, y, z in r0; the tube's axis is z, one cell's mean point is the
    origin, and the train repeats every `base.train.period`.

    It does not depend on the viscosity inside the cells, which move rigidly.

    **Raises:** `CaseError` for a point outside the tube.
    """
    points = np.asarray(points, dtype=float)
    beyond = -train_tube(base.train).wall.distance(points)
    # A point on the wall may lie outside by roundoff.
    if beyond.size and beyond.max() > ROUNDING * base.train.radius:
        raise CaseError(
            f"a point {beyond.max():g} r0 beyond the wall is not allowed: the tube's radius is"
            f" {base.train.radius:g} r0"
        )
    # Into the period about the cell at the origin.
    inside = points.copy()
    inside[:, 2] -= base.train.period * np.round(inside[:, 2] / base.train.period)
    operator = train_operator(base.train)
    return np.asarray(
        _velocity(operator, jnp.asarray(inside), jnp.asarray(base.coefficients)[None])
    )
