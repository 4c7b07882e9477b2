"""Nonuniform Fourier transforms in two and three dimensions, on whatever platform a program runs.

    points to modes:  f^(k) = sum_s f_s exp(-i k . x_s)
    modes to points:  f(x)  = sum_k f^(k) exp(i k . x)

with angles x and whole numbers k from -n//2 on. On processors by FINUFFT (*Barnett, Magland & af
Klinteberg 2019*); where `jax_finufft` was not built for a platform, by the same method in JAX
itself: points are spread over a grid of `UPSAMPLING` times the modes by the kernel
exp(beta (sqrt(1 - t^2) - 1)), |t| <= 1, which is transformed, and divided by the kernel's own
transform.
"""

import math
from functools import cache, reduce
from importlib.util import find_spec
from typing import TypeAlias

import jax
import jax.numpy as jnp
import numpy as np
from jax_finufft import nufft1, nufft2
from jaxtyping import Array, Complex, Float
from scipy.fft import next_fast_len

from celltrain.runtime import NUFFT_OPTIONS, by_platform

Angles: TypeAlias = tuple[Float[Array, " point"], ...]
Shape: TypeAlias = tuple[int, ...]

#: Platforms for which `jax_finufft` was built.
BUILT = ("cpu", *(("cuda",) if find_spec("jax_finufft.jax_finufft_gpu") else ()))
#: Grid points for each mode along each axis.
UPSAMPLING = 2.0
# Shape of the kernel for each grid point that it covers, at this upsampling.
STEEPNESS = 2.3
# Values of kernels held at a time.
MOST_VALUES = 2**22


def points_to_modes(
    shape: Shape, values: Complex[Array, "part point"], angles: Angles, tolerance: float
) -> Complex[Array, "part *mode"]:
    """Modes of values at points; errors relative to the largest are of the size of `tolerance`."""

    def built(values: Array, *angles: Array) -> Array:
        found: Array = nufft1(shape, values, *angles, eps=tolerance, iflag=-1, opts=NUFFT_OPTIONS)
        return found

    def plain(values: Array, *angles: Array) -> Array:
        return plain_points_to_modes(shape, values, angles, tolerance)

    return by_platform(dict.fromkeys(BUILT, built), plain, values, *angles)


def modes_to_points(
    modes: Complex[Array, "part *mode"], angles: Angles, tolerance: float
) -> Complex[Array, "part point"]:
    """Values at points of fields with these modes, to `tolerance` as `points_to_modes`."""

    def built(modes: Array, *angles: Array) -> Array:
        found: Array = nufft2(modes, *angles, eps=tolerance, iflag=1, opts=NUFFT_OPTIONS)
        return found

    def plain(modes: Array, *angles: Array) -> Array:
        return plain_modes_to_points(modes, angles, tolerance)

    return by_platform(dict.fromkeys(BUILT, built), plain, modes, *angles)


def fields_at_points(
    modes: Complex[Array, "field *mode"], angles: Angles, tolerance: float
) -> Float[Array, "field point"]:
    """Values at points of real fields, of which two share a transform, to `tolerance`."""
    pairs = modes_to_points(in_pairs(modes), angles, tolerance)
    both = jnp.stack([pairs.real, pairs.imag], axis=1)
    return both.reshape(-1, both.shape[-1])[: len(modes)]


def in_pairs(components: Array) -> Array:
    """Components a_0 + i a_1, a_2 + i a_3, ..., for transforms of which each a is real."""
    if components.shape[0] % 2:
        components = jnp.concatenate([components, jnp.zeros_like(components[:1])])
    return components[0::2] + 1j * components[1::2]


def plain_points_to_modes(
    shape: Shape, values: Complex[Array, "part point"], angles: Angles, tolerance: float
) -> Complex[Array, "part *mode"]:
    """The same by JAX alone."""
    width, sizes = _kernel_width(tolerance), _sizes(shape, tolerance)
    grid = jnp.zeros((len(values), math.prod(sizes)), dtype=complex)

    def add(grid: Array, some: tuple[Array, Array]) -> tuple[Array, None]:
        places, weights = _spread(some[1], sizes, width)
        spread = some[0].T[:, :, None] * weights
        return grid.at[:, places.ravel()].add(spread.reshape(len(grid), -1)), None

    count = values.shape[1]
    batch = max(1, min(count, MOST_VALUES // (len(values) * width ** len(shape))))
    grid, _ = jax.lax.scan(add, grid, (_batches(values.T, batch), _batches(_stack(angles), batch)))
    transformed = jnp.fft.fftn(grid.reshape(-1, *sizes), axes=_axes(shape))
    return _chosen(transformed, shape) / _kernel_modes(shape, sizes, width)


def plain_modes_to_points(
    modes: Complex[Array, "part *mode"], angles: Angles, tolerance: float
) -> Complex[Array, "part point"]:
    """The same by JAX alone."""
    parts, *counts = modes.shape
    shape = tuple(counts)
    width, sizes = _kernel_width(tolerance), _sizes(shape, tolerance)
    divided = modes / _kernel_modes(shape, sizes, width)
    # Not by setting elements: XLA does that for complex numbers on GPUs one by one.
    missing = (size - n for n, size in zip(shape, sizes, strict=True))
    padded = jnp.pad(divided, ((0, 0), *((0, each) for each in missing)))
    padded = jnp.roll(padded, [-(n // 2) for n in shape], axis=_axes(shape))
    grid = jnp.fft.ifftn(padded, axes=_axes(shape), norm="forward").reshape(parts, -1)

    def take(angles: Array) -> Array:
        places, weights = _spread(angles, sizes, width)
        return jnp.einsum("apk,pk->pa", grid[:, places], weights)

    count = len(angles[0])
    batch = max(1, min(count, MOST_VALUES // (parts * width ** len(shape))))
    found = jax.lax.map(take, _batches(_stack(angles), batch))
    return found.reshape(-1, parts)[:count].T


def _axes(shape: Shape) -> tuple[int, ...]:
    return tuple(range(1, len(shape) + 1))


def _stack(angles: Angles) -> Float[Array, "point axis"]:
    return jnp.stack(angles, axis=1)


def _batches(values: Array, batch: int) -> Array:
    """Rows in batches of one size; rows of zeros fill up the last."""
    missing = -len(values) % batch
    filled = jnp.concatenate([values, jnp.zeros((missing, *values.shape[1:]), values.dtype)])
    return filled.reshape(-1, batch, *values.shape[1:])


def _spread(angles: Array, sizes: Shape, width: int) -> tuple[Array, Array]:
    """Numbers of the grid points that each point reaches, and the kernel there [point, grid]."""
    places = jnp.zeros((len(angles), 1), dtype=int)
    weights = jnp.ones((len(angles), 1))
    for axis, size in enumerate(sizes):
        turns = angles[:, axis] / (2.0 * math.pi)
        place = size * (turns - jnp.floor(turns))
        first = jnp.ceil(place - 0.5 * width)
        numbers = first[:, None] + jnp.arange(width)
        along = numbers.astype(int) % size
        places = (places[:, :, None] * size + along[:, None]).reshape(len(angles), -1)
        kernel = _kernel(numbers - place[:, None], width)
        weights = (weights[:, :, None] * kernel[:, None]).reshape(len(angles), -1)
    return places, weights


def _kernel(distance: Array, width: int) -> Array:
    """The kernel at distances in grid points, of a support of `width`."""
    # Not quite zero at its edge, where the root has no derivative.
    inside = jnp.maximum(1.0 - (2.0 / width * distance) ** 2, 1e-30)
    return jnp.exp(STEEPNESS * width * (jnp.sqrt(inside) - 1.0))


def _kernel_width(tolerance: float) -> int:
    """Grid points that the kernel covers: one for each decimal digit, and two more."""
    return math.ceil(-math.log10(tolerance)) + 2


def _sizes(shape: Shape, tolerance: float) -> Shape:
    least = 2 * _kernel_width(tolerance)
    return tuple(
        next_fast_len(max(least, math.ceil(UPSAMPLING * count)), real=False) for count in shape
    )


def _numbers(count: int) -> np.ndarray:
    return np.arange(count) - count // 2


def _chosen(transformed: Array, shape: Shape) -> Array:
    """The wanted modes, in the order of their numbers."""
    for axis, count in enumerate(shape, start=1):
        transformed = jnp.take(transformed, _numbers(count), axis=axis, mode="wrap")
    return transformed


def _kernel_modes(shape: Shape, sizes: Shape, width: int) -> Float[np.ndarray, " *mode"]:
    along = (_kernel_mode(n, size, width) for n, size in zip(shape, sizes, strict=True))
    return reduce(np.multiply.outer, along)


@cache
def _kernel_mode(count: int, size: int, width: int) -> Float[np.ndarray, " mode"]:
    """Fourier transform of the kernel at the wave numbers of an axis, in grid points."""
    nodes, weights = np.polynomial.legendre.leggauss(4 * width + 20)
    values = np.exp(STEEPNESS * width * (np.sqrt(1.0 - nodes**2) - 1.0))
    waves = np.pi * width / size * _numbers(count)
    found: np.ndarray = 0.5 * width * np.cos(np.outer(waves, nodes)) @ (weights * values)
    return found
