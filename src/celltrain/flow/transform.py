"""Fourier transforms between points in the tube and the wave vectors of the far kernel.

    analyse:     f^(k) = sum_s f_s exp(-i k . y_s)
    synthesise:  u(x)  = sum_k u^(k) exp(i k . x)

Two arrangements of points are known. `RingTransform` needs points that form rings about the tube's
axis (an axisymmetric train, the wall): the transform then splits into an azimuthal and an axial
matrix product. `NonuniformTransform` takes any points (FINUFFT; Barnett, Magland & af Klinteberg
2019). Derivatives in any direction are exact in both, also those that break the rings: they are
transforms of other strengths at the same points.

Points have the shape [ring, azimuth, 3]; loose points are rings of one azimuth. Inside, they are in
parts of the box and wave vectors in radians per box, so that a box's size may vary: derivatives by
it (of rings that stay rings) follow from those of the points' parts.
"""

import abc
import math
from collections.abc import Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax_finufft import nufft1, nufft2
from jaxtyping import Array, Float

from celltrain.flow.ewald import EwaldSplit
from celltrain.flow.shared_sizes import shared_size
from celltrain.runtime import NUFFT_OPTIONS

Points = Float[Array, "ring azimuth 3"]
# One of several sets, each of which has its own number of rings and azimuths.
PointSet = Float[Array, "_ _ 3"]


class Transform(eqx.Module):
    """Transform between points and the modes of one box; modes are arrays [part, *mode].

    `box` is its size in r0, along x, y and z.
    """

    box: Float[Array, "3"]

    def wave_vectors(self) -> tuple[Array, Array, Array]:
        """Components kx, ky, kz, broadcastable to the shape of the modes, in 1/r0."""
        x, y, z = (turn / self.box[i] for i, turn in enumerate(self._turns()))
        return x, y, z

    @abc.abstractmethod
    def _turns(self) -> tuple[Array, Array, Array]:
        """The same in radians per box."""

    @abc.abstractmethod
    def _analyse(self, points: Points, strengths: Array) -> Array:
        """Transform of strengths [component, ring, azimuth] to modes [component, *mode].

        The points are in parts of the box.
        """

    @abc.abstractmethod
    def _synthesise(self, points: Sequence[PointSet], modes: Array) -> tuple[Array, ...]:
        """Sums [component, ring, azimuth] of modes [component, *mode] for each set of points.

        The points are in parts of the box.
        """

    def analyse(self, points: Points, strengths: Float[Array, "ring azimuth part"]) -> Array:
        """Modes [part, *mode] of real strengths at the points, differentiable in both."""
        return _analysed(self, points / self.box, strengths)

    def synthesise(self, points: Sequence[PointSet], modes: Array) -> tuple[Array, ...]:
        """Velocities [ring, azimuth, 3] at each set of points, differentiable in both.

        Those of rings are complex, with an imaginary part of roundoff unless there is a phase.
        """
        return _synthesised(self, tuple(each / self.box for each in points), modes)


# Transforms and their derivatives of points in parts of the box. Both take all that they need as
# arguments, the box apart, on which they do not depend: so they can be differentiated twice.


@jax.custom_jvp
def _analysed(transform: Transform, points: Points, strengths: Array) -> Array:
    return transform._analyse(points, jnp.moveaxis(strengths, -1, 0))


@_analysed.defjvp
def _analysed_jvp(primals, tangents):  # type: ignore[no-untyped-def]
    transform, points, strengths = primals
    _, d_points, d_strengths = tangents
    dipoles = strengths[..., None, :] * d_points[..., :, None]
    parts = strengths.shape[-1]
    sources = jnp.concatenate([d_strengths[..., None, :], dipoles], axis=-2)
    sources = jnp.moveaxis(sources.reshape(*points.shape[:2], 4 * parts), -1, 0)
    moved = transform._analyse(points, sources)
    moved = moved.reshape(4, parts, *moved.shape[1:])
    change = moved[0]
    for component, part in zip(transform._turns(), moved[1:], strict=True):
        change = change - 1j * component * part
    return _analysed(transform, points, strengths), change


@jax.custom_jvp
def _synthesised(
    transform: Transform, points: tuple[PointSet, ...], modes: Array
) -> tuple[Array, ...]:
    return tuple(jnp.moveaxis(u, 0, -1) for u in transform._synthesise(points, modes))


@_synthesised.defjvp
def _synthesised_jvp(primals, tangents):  # type: ignore[no-untyped-def]
    transform, points, modes = primals
    _, d_points, d_modes = tangents
    slopes = jnp.concatenate([1j * component * modes for component in transform._turns()])
    gradients = transform._synthesise(points, slopes)
    changes = _synthesised(transform, points, d_modes)
    moved = []
    for d_x, gradient, change in zip(d_points, gradients, changes, strict=True):
        by_direction = gradient.reshape(3, 3, *gradient.shape[1:])
        moved.append(change + jnp.einsum("rak,kcra->rac", d_x, by_direction))
    return _synthesised(transform, points, modes), tuple(moved)


def _in_pairs(components: Array) -> Array:
    """Components a_0 + i a_1, a_2 + i a_3, ..., for transforms of which each a is real."""
    if components.shape[0] % 2:
        components = jnp.concatenate([components, jnp.zeros_like(components[:1])])
    return components[0::2] + 1j * components[1::2]


def _mode_numbers(length: float, largest: float, *, shared: bool) -> np.ndarray:
    count = math.ceil(largest * length / (2.0 * math.pi))
    count = shared_size(count) if shared else count
    return np.arange(-count, count + 1)


class RingTransform(Transform):
    """Separable transform for points in rings about the axis; modes are [axial, across].

    Wave vectors across lie in a disc. `axial` may carry a phase q: the modes then are those of a
    field that is periodic up to the factor exp(i q) per period. Both in radians per box.
    """

    across: Float[Array, "2 across"]
    axial: Float[Array, " axial"]

    def _turns(self) -> tuple[Array, Array, Array]:
        """Components kx, ky [1, across] and kz [axial, 1]."""
        return self.across[0][None], self.across[1][None], self.axial[:, None]

    def _phases(self, points: Points) -> tuple[Array, Array]:
        """Real and imaginary part [ring, azimuth, 2 across] of the phase across; axial phase."""
        radius = jnp.hypot(points[:, :1, 0], points[:, :1, 1])
        direction = points[..., :2] / jnp.hypot(points[..., 0], points[..., 1])[..., None]
        angle = radius[..., None] * (direction @ self.across)
        across = jnp.concatenate([jnp.cos(angle), jnp.sin(angle)], axis=-1)
        return across, jnp.exp(1j * points[:, 0, 2:] * self.axial)

    def _analyse(self, points: Points, strengths: Array) -> Array:
        across, axial = self._phases(points)
        count = self.across.shape[1]
        by_ring = jnp.einsum("rak,cra->rck", across, strengths)
        by_ring = by_ring[..., :count] - 1j * by_ring[..., count:]
        return jnp.einsum("rz,rck->czk", jnp.conj(axial), by_ring)

    def _synthesise(self, points: Sequence[PointSet], modes: Array) -> tuple[Array, ...]:
        sums = []
        for each in points:
            across, axial = self._phases(each)
            by_ring = jnp.einsum("rz,czk->rck", axial, modes)
            # Real matrix times the stacked parts of a complex one: (c + i s)(a + i b).
            parts = jnp.concatenate([by_ring.real, -by_ring.imag], axis=-1)
            cross = jnp.concatenate([by_ring.imag, by_ring.real], axis=-1)
            sums.append(
                jnp.einsum("rak,rck->cra", across, parts)
                + 1j * jnp.einsum("rak,rck->cra", across, cross)
            )
        return tuple(sums)


class NonuniformTransform(Transform):
    """Nonuniform fast Fourier transform for any points; modes are [x, y, z] wave numbers.

    For real fields: two components share one complex transform, and velocities come out real.
    """

    shape: tuple[int, int, int] = eqx.field(static=True)
    tolerance: float = eqx.field(static=True)

    def _turns(self) -> tuple[Array, Array, Array]:
        """Components along the three axes of the modes."""
        x, y, z = (2.0 * math.pi * (jnp.arange(n) - n // 2) for n in self.shape)
        return x[:, None, None], y[None, :, None], z[None, None, :]

    def _angles(self, points: Sequence[PointSet]) -> tuple[Array, Array, Array]:
        loose = jnp.concatenate([each.reshape(-1, 3) for each in points])
        x, y, z = (2.0 * math.pi * loose[:, i] for i in range(3))
        return x, y, z - 2.0 * math.pi * jnp.round(loose[:, 2])

    def _analyse(self, points: Points, strengths: Array) -> Array:
        count = strengths.shape[0]
        pairs = _in_pairs(strengths.reshape(count, -1))
        modes = nufft1(
            self.shape,
            pairs,
            *self._angles([points]),
            eps=self.tolerance,
            iflag=-1,
            opts=NUFFT_OPTIONS,
        )
        # Transforms of real strengths a, b from that of a + i b, by their symmetry under k -> -k.
        mirrored = jnp.conj(modes[:, ::-1, ::-1, ::-1])
        both = jnp.stack([0.5 * (modes + mirrored), -0.5j * (modes - mirrored)], axis=1)
        return both.reshape(-1, *self.shape)[:count]

    def _synthesise(self, points: Sequence[PointSet], modes: Array) -> tuple[Array, ...]:
        pairs = nufft2(
            _in_pairs(modes),
            *self._angles(points),
            eps=self.tolerance,
            iflag=1,
            opts=NUFFT_OPTIONS,
        )
        loose = jnp.stack([pairs.real, pairs.imag], axis=1).reshape(-1, pairs.shape[-1])
        loose = loose[: modes.shape[0]]
        sizes = [each.shape[0] * each.shape[1] for each in points]
        parts = jnp.split(loose, np.cumsum(sizes)[:-1], axis=1)
        return tuple(
            part.reshape(-1, *each.shape[:2]) for part, each in zip(parts, points, strict=True)
        )


def ring_transform(
    split: EwaldSplit, width: float, period: float, phase: float = 0.0
) -> RingTransform:
    """Transform for rings in a box (sizes in r0); `phase` is q in radians per period."""
    largest = split.largest_wave_number
    numbers = _mode_numbers(width, largest, shared=True)
    x, y = (grid.ravel() for grid in np.meshgrid(numbers, numbers, indexing="ij"))
    # A disc of a whole number of waves, so that equal numbers across give equal sizes.
    inside = x**2 + y**2 <= numbers[-1] ** 2
    across = 2.0 * math.pi * np.stack([x[inside], y[inside]])
    # One number of modes for all phases up to half a turn, so they can be stacked.
    numbers = _mode_numbers(period, largest + math.pi / period, shared=True)
    axial = 2.0 * math.pi * numbers + phase
    return RingTransform(_box(width, period), jnp.asarray(across), jnp.asarray(axial))


def nonuniform_transform(
    split: EwaldSplit, width: float, period: float, tolerance: float
) -> NonuniformTransform:
    """Transform for any points in a box (sizes in r0)."""
    largest = split.largest_wave_number
    # Its cost grows with the number of modes, and a simulation has programs of its own anyway.
    across = _mode_numbers(width, largest, shared=False).size
    axial = _mode_numbers(period, largest, shared=False).size
    return NonuniformTransform(_box(width, period), (across, across, axial), tolerance)


def _box(width: float, period: float) -> Float[Array, "3"]:
    return jnp.array([width, width, period], dtype=float)
