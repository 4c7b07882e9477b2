"""Sums between points and the regular grid about them, for nonuniform Fourier transforms.

    spread:       g(j) = sum_s f_s K(j - x_s)
    interpolate:  f(x) = sum_j g(j) K(j - x)

on a grid that is periodic along each axis, x in its steps. The kernel is a product over the axes of

    K(d) = exp(beta (sqrt(1 - t^2) - 1)),   t = 2 d/w,   |t| <= 1,

of *Barnett, Magland & af Klinteberg 2019*, where w is the number of grid points that it covers and
beta grows with it. It is computed as a polynomial in each step. The sums are compiled loops, and
plain formulas where these do not serve.
"""

import math
from functools import cache
from typing import TypeAlias

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from celltrain.compiled import compiled_or_plain, loop
from celltrain.compiled.loops import INTERPOLATE, SPREAD

#: Numbers of grid points along each axis.
Sizes: TypeAlias = tuple[int, ...]
Grid: TypeAlias = Float[Array, "field *place"]
#: Where points are on a grid, in its steps.
Places: TypeAlias = Float[Array, "point axis"]
Values: TypeAlias = Float[Array, "point field"]

# beta for each grid point that the kernel covers: about least errors for fields of which nothing is
# left at the largest wave numbers, on a grid of a quarter more points than modes.
STEEPNESS = 2.4
# Values of kernels that the plain formulas hold at a time.
MOST_VALUES = 2**22


def kernel_width(tolerance: float) -> int:
    """Grid points that the kernel covers: one for each decimal digit, and one more."""
    return math.ceil(-math.log10(tolerance)) + 1


def _kernel(distance: np.ndarray, width: int) -> np.ndarray:
    inside = np.maximum(1.0 - (2.0 / width * distance) ** 2, 0.0)
    found: np.ndarray = np.exp(STEEPNESS * width * (np.sqrt(inside) - 1.0))
    return found


def kernel_transform(waves: Float[np.ndarray, "..."], width: int) -> Float[np.ndarray, "..."]:
    """Fourier transform of the kernel along an axis, at waves in turns for each grid step."""
    nodes, weights = np.polynomial.legendre.leggauss(4 * width + 20)
    values = weights * _kernel(0.5 * width * nodes, width)
    found: np.ndarray = np.cos(np.pi * width * waves[..., None] * nodes) @ values
    return 0.5 * width * found


@cache
def kernel_terms(width: int) -> Float[np.ndarray, "term covered"]:
    """The kernel at each grid point that a point covers, from the highest term.

    It is a polynomial in the distance of the first one from the end of the kernel, from 0 to 1. Its
    error is about that of cutting the kernel at its ends, or of rounding, 6e-15.
    """
    count = width + 4
    nodes = 0.5 + 0.5 * np.cos((np.arange(count) + 0.5) * np.pi / count)
    values = _kernel(nodes[:, None] + np.arange(width) - 0.5 * width, width)
    fitted = np.polynomial.Chebyshev.fit
    rows = [
        fitted(nodes, each, count - 1, domain=[0.0, 1.0]).convert(kind=np.polynomial.Polynomial)
        for each in values.T
    ]
    return np.array([each.coef[::-1] for each in rows]).T


def grid_places(angles: Float[Array, "point axis"], sizes: Sizes) -> Places:
    """Where points of some angles are on a grid that one turn goes around."""
    turns = angles / (2.0 * math.pi)
    return (turns - jnp.floor(turns)) * np.array(sizes, dtype=float)


def spread(values: Values, places: Places, sizes: Sizes, width: int) -> Grid:
    """The grid of values at points, by a kernel that covers so many grid points."""

    def compiled(values: Array, places: Array) -> Array:
        shape = (values.shape[1], *_box(sizes))
        found = loop(SPREAD, shape, values, _in_box(places), _terms_in_box(width, len(sizes)))
        return found.reshape(-1, *sizes)

    def plain(values: Array, places: Array) -> Array:
        return plain_spread(values, places, sizes, width)

    return compiled_or_plain(compiled, plain, values, places)


def interpolate(grid: Grid, places: Places, width: int) -> Values:
    """Values at points of fields on a grid, by a kernel that covers so many grid points."""

    def compiled(grid: Array, places: Array) -> Array:
        given = grid.reshape(-1, *_box(grid.shape[1:]))
        shape = (len(places), len(grid))
        terms = _terms_in_box(width, places.shape[1])
        return loop(INTERPOLATE, shape, given, _in_box(places), terms)

    def plain(grid: Array, places: Array) -> Array:
        return plain_interpolate(grid, places, width)

    return compiled_or_plain(compiled, plain, grid, places)


def _box(sizes: Sizes) -> Sizes:
    """Grid points in three dimensions: a plane is one layer of a box."""
    return (*(1,) * (3 - len(sizes)), *sizes)


def _in_box(places: Places) -> Float[Array, "point 3"]:
    return jnp.pad(places, ((0, 0), (3 - places.shape[1], 0)))


def _terms_in_box(width: int, axes: int) -> Float[Array, "term 3 covered"]:
    """The kernel along each axis; along those that a plane lacks, 1 at its one point."""
    terms = kernel_terms(width)
    found = np.zeros((len(terms), 3, width))
    found[:, 3 - axes :] = terms[:, None]
    found[-1, : 3 - axes, 0] = 1.0
    return jnp.asarray(found)


def plain_spread(values: Values, places: Places, sizes: Sizes, width: int) -> Grid:
    """The same by JAX alone."""
    fields = values.shape[1]

    def add(grid: Array, some: tuple[Array, ...]) -> tuple[Array, None]:
        values, places = some
        numbers, weights = _covered(places, sizes, width)
        spread = values.T[:, :, None] * weights
        return grid.at[:, numbers.ravel()].add(spread.reshape(fields, -1)), None

    batches = _batches((values, places), fields * width ** len(sizes))
    grid, _ = jax.lax.scan(add, jnp.zeros((fields, math.prod(sizes))), batches)
    return grid.reshape(fields, *sizes)


def plain_interpolate(grid: Grid, places: Places, width: int) -> Values:
    """The same by JAX alone."""
    fields, *sizes = grid.shape
    flat = grid.reshape(fields, -1)

    def take(places: Array) -> Array:
        numbers, weights = _covered(places, tuple(sizes), width)
        return jnp.einsum("fpk,pk->pf", flat[:, numbers], weights)

    (batches,) = _batches((places,), fields * width ** len(sizes))
    return jax.lax.map(take, batches).reshape(-1, fields)[: len(places)]


def _batches(arrays: tuple[Array, ...], covered: int) -> tuple[Array, ...]:
    """Rows, each of so many values of kernels, in batches of one size; zeros fill up the last.

    Two at least: XLA then stores the places before the loop, and all that is computed from them
    agrees.
    """
    count = len(arrays[0])
    size = max(1, min(-(-count // 2), MOST_VALUES // max(1, covered)))
    batches = max(2, -(-count // size))

    def filled(rows: Array) -> Array:
        missing = ((0, batches * size - count), (0, 0))
        return jnp.pad(rows, missing).reshape(batches, size, -1)

    return tuple(map(filled, arrays))


def _covered(
    places: Places, sizes: Sizes, width: int
) -> tuple[Int[Array, "point grid"], Float[Array, "point grid"]]:
    """Numbers of all grid points that each point reaches, and the kernel there."""
    start = places - 0.5 * width
    lowest = jnp.ceil(start)
    # Not from the place again, which a program may compute twice, with other roundings: a point of
    # the grid would then be the first that is covered, and its neighbour where the kernel begins.
    offset = lowest - start
    kernel = jnp.zeros((*places.shape, width))
    for term in kernel_terms(width):
        kernel = kernel * offset[..., None] + term
    numbers, weights = jnp.zeros((len(places), 1), dtype=int), jnp.ones((len(places), 1))
    for axis, size in enumerate(sizes):
        along = (lowest[:, axis, None].astype(int) + np.arange(width)) % size
        numbers = (numbers[:, :, None] * size + along[:, None]).reshape(len(places), -1)
        weights = (weights[:, :, None] * kernel[:, None, axis]).reshape(len(places), -1)
    return numbers, weights
