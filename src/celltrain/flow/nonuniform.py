"""Nonuniform Fourier transforms of real fields, in two and three dimensions.

    points to modes:  f^(k) = sum_s f_s exp(-i k . x_s)
    modes to points:  f(x)  = sum_k f^(k) exp(i k . x)

with angles x and whole numbers k up to the largest along each axis. Modes stand in the order of
their numbers, from the lowest; those with a negative last number are left out, as f^(-k) is the
conjugate of f^(k), and those whose last number is 0 are conjugates of each other. Both have forward
derivatives, which are transforms of other values at the same points.

Points are spread over a grid of `UPSAMPLING` times the modes by a narrow kernel (see `spreading`).
The grid is transformed, and divided by the kernel's own transform (*Barnett, Magland & af
Klinteberg 2019*). The kernel and the grid are those for resolved fields, of which no more than the
tolerance is left at the largest numbers: what is wrong by more there does not count.
"""

import math
from collections.abc import Callable
from functools import partial
from typing import TypeAlias

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Complex, Float
from scipy.fft import next_fast_len

from celltrain.flow.spreading import (
    Grid,
    Sizes,
    Values,
    grid_places,
    interpolate,
    kernel_transform,
    kernel_width,
    spread,
)

Angles: TypeAlias = Float[Array, "point axis"]
Modes: TypeAlias = Complex[Array, "field *number"]
#: The largest number along each axis.
Largest: TypeAlias = tuple[int, ...]

# Grid points for each mode along each axis.
UPSAMPLING = 1.25
# Values on the grids of the fields that are transformed at a time, and least number of fields.
MOST_GRID_VALUES, LEAST_FIELDS = 2**21, 3


@partial(jax.custom_jvp, nondiff_argnums=(0, 3))
def points_to_modes(largest: Largest, values: Values, angles: Angles, tolerance: float) -> Modes:
    """Modes of values at points.

    Where the largest modes are made as small as the tolerance afterwards, errors are about as
    large as that, relative to the largest.
    """
    sizes, width = _sizes(largest, tolerance), kernel_width(tolerance)
    places = grid_places(angles, sizes)

    def some(values: Array) -> Modes:
        return _modes(spread(values.T, places, sizes, width), largest, width)

    return _by_batches(some, values.T, sizes)


def _modes(grid: Grid, largest: Largest, width: int) -> Modes:
    """Modes of the values that were spread over a grid."""
    sizes = grid.shape[1:]
    found = jnp.fft.rfftn(grid, axes=_axes(sizes))[..., : largest[-1] + 1]
    for axis, (most, size) in enumerate(zip(largest[:-1], sizes, strict=False), start=1):
        below = jax.lax.slice_in_dim(found, size - most, size, axis=axis)
        others = jax.lax.slice_in_dim(found, 0, most + 1, axis=axis)
        found = jnp.concatenate([below, others], axis=axis)
    return _without_kernel(found, sizes, width)


@points_to_modes.defjvp
def _points_to_modes_jvp(largest, tolerance, primals, tangents):  # type: ignore[no-untyped-def]
    values, angles = primals
    d_values, d_angles = tangents
    moments = [values * along[:, None] for along in d_angles.T]
    moved = points_to_modes(
        largest, jnp.concatenate([d_values, *moments], axis=1), angles, tolerance
    )
    change, *by_axis = jnp.split(moved, 1 + len(largest))
    for number, part in zip(numbers_of_modes(largest), by_axis, strict=True):
        change = change - 1j * number * part
    return points_to_modes(largest, values, angles, tolerance), change


@partial(jax.custom_jvp, nondiff_argnums=(2,))
def modes_to_points(modes: Modes, angles: Angles, tolerance: float) -> Values:
    """Values at points of fields whose largest modes are as small as the tolerance.

    Errors are about as large as that, relative to the largest.
    """
    sizes, width = _sizes(_largest(modes), tolerance), kernel_width(tolerance)
    places = grid_places(angles, sizes)

    def some(modes: Modes) -> Array:
        return interpolate(_grid(modes, sizes, width), places, width).T

    return _by_batches(some, modes, sizes).T


def _by_batches(transform: Callable[[Array], Array], fields: Array, sizes: Sizes) -> Array:
    """The transforms of fields, [field, ...], some at a time if there are many.

    Their grids then stay in the same memory, which the system would have to clear for more.
    """
    count = len(fields)
    most = max(LEAST_FIELDS, MOST_GRID_VALUES // math.prod(sizes))
    if count <= most:
        return transform(fields)
    batches = -(-count // most)
    size = -(-count // batches)
    missing = ((0, batches * size - count), *((0, 0),) * (fields.ndim - 1))
    filled = jnp.pad(fields, missing).reshape(batches, size, *fields.shape[1:])
    found = jax.lax.map(transform, filled)
    return found.reshape(-1, *found.shape[2:])[:count]


def _grid(modes: Modes, sizes: Sizes, width: int) -> Grid:
    """Fields on the grid that, interpolated, have these modes."""
    largest = _largest(modes)
    found = _without_kernel(modes, sizes, width)
    for axis, (most, size) in enumerate(zip(largest[:-1], sizes, strict=False), start=1):
        below = jax.lax.slice_in_dim(found, 0, most, axis=axis)
        others = jax.lax.slice_in_dim(found, most, 2 * most + 1, axis=axis)
        shape = list(found.shape)
        shape[axis] = size - 2 * most - 1
        found = jnp.concatenate([others, jnp.zeros(shape, found.dtype), below], axis=axis)
    return jnp.fft.irfftn(found, sizes, _axes(sizes), norm="forward")


@modes_to_points.defjvp
def _modes_to_points_jvp(tolerance, primals, tangents):  # type: ignore[no-untyped-def]
    modes, angles = primals
    d_modes, d_angles = tangents
    slopes = [1j * number * modes for number in numbers_of_modes(_largest(modes))]
    found = modes_to_points(jnp.concatenate([d_modes, *slopes]), angles, tolerance)
    change, *gradient = jnp.split(found, 1 + angles.shape[1], axis=1)
    for along, part in zip(d_angles.T, gradient, strict=True):
        change = change + part * along[:, None]
    return modes_to_points(modes, angles, tolerance), change


def _largest(modes: Modes) -> Largest:
    *across, along = modes.shape[1:]
    return (*(count // 2 for count in across), along - 1)


def numbers_of_modes(largest: Largest) -> list[np.ndarray]:
    """Numbers of the modes along each axis, broadcastable to all modes."""
    *across, along = largest
    numbers = [*(np.arange(-most, most + 1) for most in across), np.arange(along + 1)]
    count = len(numbers)
    return [each.reshape(-1, *(1,) * (count - 1 - axis)) for axis, each in enumerate(numbers)]


def _axes(sizes: Sizes) -> tuple[int, ...]:
    return tuple(range(1, len(sizes) + 1))


def _sizes(largest: Largest, tolerance: float) -> Sizes:
    least = 2 * kernel_width(tolerance)
    return tuple(
        next_fast_len(max(least, math.ceil(UPSAMPLING * (2 * most + 1))), real=True)
        for most in largest
    )


def _without_kernel(modes: Modes, sizes: Sizes, width: int) -> Modes:
    """Modes divided by the kernel's."""
    for numbers, size in zip(numbers_of_modes(_largest(modes)), sizes, strict=True):
        # One after the other: their product is as large as the modes.
        modes = modes * (1.0 / kernel_transform(numbers / size, width))
    return modes
