"""Velocity of the fluid in a steady train."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from celltrain.parameters import CaseError
from celltrain.steady import Base
from celltrain.train.operator import TrainOperator, train_operator


@eqx.filter_jit
def _velocity(operator: TrainOperator, points: Array, shapes: Array) -> Array:
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
    distance = np.hypot(points[:, 0], points[:, 1])
    # A point on the wall may lie outside by roundoff.
    if distance.size and distance.max() > base.train.radius * (1.0 + 1e-12):
        raise CaseError(
            f"a point at the distance {distance.max():g} r0 from the axis is not allowed: the"
            f" tube's radius is {base.train.radius:g} r0"
        )
    # Into the period about the cell at the origin.
    inside = points.copy()
    inside[:, 2] -= base.train.period * np.round(inside[:, 2] / base.train.period)
    operator = train_operator(base.train)
    return np.asarray(
        _velocity(operator, jnp.asarray(inside), jnp.asarray(base.coefficients)[None])
    )
