"""How accurate the rates of change are, from a second evaluation with finer rules."""

import math

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from celltrain.harmonics import Shapes
from celltrain.harmonics.jax_shapes import JaxShapes
from celltrain.parameters import Train
from celltrain.programs import Program
from celltrain.train.operator import CellsOperator, train_operator

# Finer in every respect but the degree of the shapes.
FINER = 1.25
# The points at which the velocity is evaluated count most where cells are close, and what is left
# of their error falls slowest.
FINER_TARGETS = 1.75
FINER_TOLERANCE = 0.1
# What is reported over the largest difference found, which is one at some points, and against rules
# that have an error themselves.
MARGIN = 1.5


def refined(train: Train) -> Train:
    """The same train with finer grids and rules and smaller tolerances, at the same degree."""
    sizes, resolution = train.sizes, train.resolution
    orders = ("energy_order", "source_order", "polar_radial")
    finer = {name: math.ceil(FINER * getattr(sizes, name)) for name in orders}
    return train.changed(
        **finer,
        target_order=math.ceil(FINER_TARGETS * sizes.target_order),
        polar_azimuthal=2 * math.ceil(0.5 * FINER * sizes.polar_azimuthal),
        near_cutoff=FINER * resolution.near_cutoff,
        tolerance=max(FINER_TOLERANCE * resolution.tolerance, 1e-12),
    )


@Program
def _velocity(
    operator: CellsOperator, values: Float[Array, "point coefficient"], shapes: JaxShapes
) -> Float[Array, "cell point 3"]:
    return jnp.einsum("pk,cik->cpi", values, operator.rates(shapes))


def rates_error(
    train: Train,
    shapes: Shapes,
    *,
    close: bool = True,
    wall_gap: float | None = None,
) -> float:
    """Estimated error of the velocity on the cells, relative to the largest one.

    The largest difference between the rates of change of the shapes with the train's rules and with
    finer ones, times a margin: everything but the degree of the shapes, whose effect see in
    `Base.truncation_error`.

    **Arguments:** `close`, `wall_gap`: as for `train_operator`.

    **Returns:** NaN if a velocity is NaN.
    """

    def operator(train: Train) -> CellsOperator:
        return train_operator(train, cells=len(shapes), close=close, wall_gap=wall_gap)

    better = operator(refined(train))
    values, points = better.target_grid.values, jnp.asarray(shapes)
    # One after the other: in one program, two sets of transforms may wait for each other forever.
    found = np.asarray(_velocity(operator(train), values, points))
    expected = np.asarray(_velocity(better, values, points))
    change = np.linalg.norm(found - expected, axis=-1).max()
    return MARGIN * float(change / np.linalg.norm(expected, axis=-1).max())
