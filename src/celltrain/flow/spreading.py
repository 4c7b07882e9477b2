"""Sums between points and the regular grid about them, for nonuniform Fourier transforms.

    spread:       g(j) = sum_s f_s K(j - x_s)
    interpolate:  f(x) = sum_j g(j) K(j - x)

on a grid that is periodic along each axis, x in its steps. The kernel is a product over the axes of

    K(d) = exp(beta (sqrt(1 - t^2) - 1)),   t = 2 d/w,   |t| <= 1,

of *Barnett, Magland & af Klinteberg 2019*, where w is the number of grid points that it covers and
beta grows with it. The sums are compiled loops, and plain formulas where these do not serve.
"""

import math
from typing import NamedTuple, TypeAlias

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from celltrain.compiled import compiled_or_plain, loop
from celltrain.compiled.loops import INTERPOLATE, SPREAD

#: Numbers of grid points along each axis.
Sizes: TypeAlias = tuple[int, ...]
Grid: TypeAlias = Float[Array, "field *place"]

# beta for each grid point that the kernel covers: least errors for fields of which nothing is left
# at the largest wave numbers, where the grid has a quarter more points than modes.
STEEPNESS = 2.4
# Values of kernels that the plain formulas hold at a time.
MOST_VALUES = 2**22


class Places(NamedTuple):
    """Where points are on a grid.

    Attributes:
        first: the first grid point that each point reaches.
        weights: the kernel there and at those that follow.
    """

    first: Int[Array, "axis point"]
    weights: Float[Array, "axis point covered"]


def kernel_width(tolerance: float) -> int:
    """Grid points that the kernel covers: one for each decimal digit, and one more."""
    return math.ceil(-math.log10(tolerance)) + 1


def kernel_transform(waves: Float[np.ndarray, "..."], width: int) -> Float[np.ndarray, "..."]:
    """Fourier transform of the kernel along an axis, at waves in turns for each grid step."""
    nodes, weights = np.polynomial.legendre.leggauss(4 * width + 20)
    values = np.exp(STEEPNESS * width * (np.sqrt(1.0 - nodes**2) - 1.0))
    found: np.ndarray = np.cos(np.pi * width * waves[..., None] * nodes) @ (weights * values)
    return 0.5 * width * found


def kernel_places(angles: Float[Array, "point axis"], sizes: Sizes, width: int) -> Places:
    """Where points of some angles are on a grid that one turn goes around."""
    turns = angles.T / (2.0 * math.pi)
    place = (turns - jnp.floor(turns)) * np.array(sizes)[:, None]
    first = jnp.ceil(place - 0.5 * width)
    distance = (first - place)[..., None] + np.arange(width)
    # Not quite zero at its edge, where the root has no derivative.
    inside = jnp.maximum(1.0 - (2.0 / width * distance) ** 2, 1e-30)
    weights = jnp.exp(STEEPNESS * width * (jnp.sqrt(inside) - 1.0))
    return Places(first.astype(int) % np.array(sizes)[:, None], weights)


def spread(values: Float[Array, "point field"], places: Places, sizes: Sizes) -> Grid:
    """The grid of values at points."""

    def compiled(values: Array, *places: Array) -> Array:
        *given, box = _in_box(Places(*places), sizes)
        found = loop(SPREAD, (values.shape[1], *box), values, *given)
        return found.reshape(-1, *sizes)

    def plain(values: Array, *places: Array) -> Array:
        return plain_spread(values, Places(*places), sizes)

    return compiled_or_plain(compiled, plain, values, *places)


def interpolate(grid: Grid, places: Places) -> Float[Array, "point field"]:
    """Values at points of fields on a grid."""

    def compiled(grid: Array, *places: Array) -> Array:
        *given, box = _in_box(Places(*places), grid.shape[1:])
        shape = (places[0].shape[1], len(grid))
        return loop(INTERPOLATE, shape, grid.reshape(-1, *box), *given)

    def plain(grid: Array, *places: Array) -> Array:
        return plain_interpolate(grid, Places(*places))

    return compiled_or_plain(compiled, plain, grid, *places)


def _in_box(places: Places, sizes: Sizes) -> tuple[Array, Array, Sizes]:
    """Places in three dimensions: a plane is one layer of a box."""
    missing = 3 - len(sizes)
    _, points, width = places.weights.shape
    # The loops pass by what has no weight.
    whole = np.zeros((missing, points, width))
    whole[..., 0] = 1.0
    first = jnp.concatenate([np.zeros((missing, points), dtype=int), places.first])
    weights = jnp.concatenate([whole, places.weights])
    return first, weights, (*(1,) * missing, *sizes)


def plain_spread(values: Float[Array, "point field"], places: Places, sizes: Sizes) -> Grid:
    """The same by JAX alone."""
    points, fields = values.shape
    width = places.weights.shape[2]
    batch = max(1, min(points, MOST_VALUES // (fields * width ** len(sizes))))
    filled = [_batches(each, batch) for each in (values, places.first.T, _by_point(places))]

    def add(grid: Array, some: list[Array]) -> tuple[Array, None]:
        numbers, weights = _products(some[1], some[2], sizes)
        spread = some[0].T[:, :, None] * weights
        return grid.at[:, numbers.ravel()].add(spread.reshape(fields, -1)), None

    grid, _ = jax.lax.scan(add, jnp.zeros((fields, math.prod(sizes))), filled)
    return grid.reshape(fields, *sizes)


def plain_interpolate(grid: Grid, places: Places) -> Float[Array, "point field"]:
    """The same by JAX alone."""
    fields, *sizes = grid.shape
    _, points, width = places.weights.shape
    batch = max(1, min(points, MOST_VALUES // (fields * width ** len(sizes))))
    flat = grid.reshape(fields, -1)

    def take(some: list[Array]) -> Array:
        numbers, weights = _products(some[0], some[1], tuple(sizes))
        return jnp.einsum("fpk,pk->pf", flat[:, numbers], weights)

    filled = [_batches(each, batch) for each in (places.first.T, _by_point(places))]
    return jax.lax.map(take, filled).reshape(-1, fields)[:points]


def _by_point(places: Places) -> Float[Array, "point axis covered"]:
    return jnp.swapaxes(places.weights, 0, 1)


def _batches(values: Array, batch: int) -> Array:
    """Rows in batches of one size; rows of zeros fill up the last."""
    missing = -len(values) % batch
    filled = jnp.concatenate([values, jnp.zeros((missing, *values.shape[1:]), values.dtype)])
    return filled.reshape(-1, batch, *values.shape[1:])


def _products(
    first: Int[Array, "point axis"], weights: Float[Array, "point axis covered"], sizes: Sizes
) -> tuple[Int[Array, "point grid"], Float[Array, "point grid"]]:
    """Numbers of all grid points that each point reaches, and the kernel there."""
    points, axes, width = weights.shape
    numbers, product = jnp.zeros((points, 1), dtype=int), jnp.ones((points, 1))
    for axis in range(axes):
        along = (first[:, axis, None] + np.arange(width)) % sizes[axis]
        numbers = (numbers[:, :, None] * sizes[axis] + along[:, None]).reshape(points, -1)
        product = (product[:, :, None] * weights[:, axis, None]).reshape(points, -1)
    return numbers, product
