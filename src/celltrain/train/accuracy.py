"""How accurate the rates of change are, from a second evaluation with finer rules."""

import math

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from celltrain.parameters import Train
from celltrain.train.operator import Shapes, TrainOperator, train_operator

# Finer in every respect but the degree of the shapes.
FINER = 1.25
FINER_TOLERANCE = 0.1


def refined(train: Train) -> Train:
    """The same train with finer grids and rules and smaller tolerances, at the same degree."""
    resolution = train.resolution
    orders = ("energy_order", "source_order", "target_order", "polar_radial")
    finer = {name: math.ceil(FINER * getattr(resolution, name)) for name in orders}
    return train.changed(
        **finer,
        polar_azimuthal=2 * math.ceil(0.5 * FINER * resolution.polar_azimuthal),
        near_cutoff=FINER * resolution.near_cutoff,
        tolerance=max(FINER_TOLERANCE * resolution.tolerance, 1e-12),
    )


@eqx.filter_jit
def _difference(
    coarse: TrainOperator, fine: TrainOperator, shapes: Shapes
) -> tuple[Array, Array]:
    """Largest change of the velocity, and largest velocity, at the points of the finer grid."""
    values = fine.target_grid.values
    found, better = (
        jnp.einsum("pk,cik->cpi", values, operator.rates(shapes)) for operator in (coarse, fine)
    )
    change = jnp.linalg.norm(found - better, axis=-1)
    return jnp.max(change), jnp.max(jnp.linalg.norm(better, axis=-1))


def rates_error(
    train: Train,
    shapes: Float[np.ndarray, "cell 3 coefficient"],
    *,
    axisymmetric: bool = False,
    close: bool = True,
    gap: float | None = None,
) -> float:
    """Estimated error of the velocity on the cells, relative to the largest one.

    The largest difference between the rates of change of the shapes with the train's rules and with
    finer ones: everything but the degree of the shapes, whose effect see in
    `Base.truncation_error`. The finer rules are more accurate by a factor of ten or more, so the
    estimate is close to the error itself.

    **Arguments:** `axisymmetric`: of axisymmetric cells, which takes a fraction of the time (and
    leaves the viscosity ratio out: they are thought to move steadily); `close`, `gap`: as for
    `train_operator`.

    **Returns:** not a number if a velocity is none.
    """
    cells = len(shapes)
    settings = {"cells": cells, "close": close, "gap": gap}
    if axisymmetric:
        train = train.changed(viscosity_ratio=1.0)
        settings["meridian"] = True
    else:
        settings["rings"] = False
    operators = (train_operator(each, **settings) for each in (train, refined(train)))
    change, largest = _difference(*operators, jnp.asarray(shapes))
    return float(change / largest)
