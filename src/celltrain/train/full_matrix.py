"""The full matrix of a train's linear dynamics, the paper's own object, by the operator in JAX.

It takes 3 M^2 directions, one for each coefficient of one cell; the other cells' columns follow
from the train's periodicity. The blocks of `linear_blocks` hold the same, computed in another way
and in a small part of the time: each is the check on the other.
"""

import abc
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from celltrain.membrane import place_cells
from celltrain.programs import Program
from celltrain.proximity.meridian import clearance
from celltrain.steady import Base
from celltrain.train.operator import CellsOperator, close_distance, train_operator

#: Directions at once, which bounds the memory of exact derivatives.
BATCH = 12

Columns = Float[Array, "direction cell 3 coefficient"]


class Derivative(abc.ABC):
    """How the columns of the matrix are computed."""

    @abc.abstractmethod
    def columns(
        self, operator: CellsOperator, shapes: Array, directions: Array, batch: int
    ) -> Columns:
        """Change of all rates per change of the shapes along each direction."""


@dataclass(frozen=True)
class ExactDerivative(Derivative):
    """Automatic differentiation."""

    def columns(
        self, operator: CellsOperator, shapes: Array, directions: Array, batch: int
    ) -> Columns:
        """Exact directional derivatives."""
        return _exact_columns(operator, shapes, directions, batch)


@dataclass(frozen=True)
class FiniteDifference(Derivative):
    """One-sided differences, Eq. (12) of Bryngelson & Freund (2018); their step is 1e-3 r0."""

    step: float = 1e-3

    def columns(
        self, operator: CellsOperator, shapes: Array, directions: Array, batch: int
    ) -> Columns:
        """Differences of the rates, one evaluation for each direction."""
        return _difference_columns(operator, shapes, directions, jnp.asarray(self.step))


@Program
def _exact_columns(
    operator: CellsOperator, shapes: Array, directions: Array, batch: int
) -> Columns:
    def column(direction: Array) -> Array:
        step = jnp.zeros_like(shapes).at[0].set(direction)
        return jax.jvp(operator.rates, (shapes,), (step,))[1]

    return jax.lax.map(column, directions, batch_size=batch)


@Program
def _difference_columns(
    operator: CellsOperator, shapes: Array, directions: Array, size: Array
) -> Columns:
    base_rates = operator.rates(shapes)

    def column(direction: Array) -> Array:
        return (operator.rates(shapes.at[0].add(size * direction)) - base_rates) / size

    return jax.lax.map(column, directions)


def matrix_operator(base: Base) -> CellsOperator:
    """The operator for all cells of a steady train, as its matrix needs it."""
    train = base.train
    apart = clearance(base.profile, train.period, train.radius)
    return train_operator(train, cells=train.cells, close=apart < close_distance(train.resolution))


def full_matrix(
    base: Base, *, derivative: Derivative | None = None, batch: int = BATCH
) -> Float[np.ndarray, "size size"]:
    """The matrix A of d(ds)/dt = A ds for all cells' coefficients, in U/r0.

    **Arguments:**

    - `base`: the steady train; `base.train.cells` = N.
    - `derivative`: `ExactDerivative()` (default) or `FiniteDifference(step)`.
    - `batch`: directions at once (exact derivatives only); bounds the memory.

    **Returns:** an array of 3 N M^2 rows and columns, ordered by cell, component (x, y, z) and
    coefficient.
    """
    derivative = ExactDerivative() if derivative is None else derivative
    cells = base.train.cells
    size = base.coefficients.size
    shapes = jnp.asarray(place_cells(base.coefficients, base.train, cells))
    directions = jnp.eye(size).reshape(size, *base.coefficients.shape)
    columns = derivative.columns(matrix_operator(base), shapes, directions, batch)
    by_cell = np.asarray(columns).reshape(size, cells, size).transpose(1, 2, 0)
    rows = [
        np.concatenate([by_cell[(row - column) % cells] for column in range(cells)], axis=1)
        for row in range(cells)
    ]
    return np.concatenate(rows)
