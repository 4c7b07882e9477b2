"""Fourier transforms between points in the tube and the wave vectors of the far kernel.

    analyse:     f^(k) = sum_s f_s exp(-i k . y_s)
    synthesise:  u(x)  = sum_k u^(k) exp(i k . x)

(see `nonuniform`). Derivatives are exact: they are transforms of other strengths at the same
points.
"""

import math

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Complex, Float

from celltrain.flow.ewald import EwaldSplit
from celltrain.flow.nonuniform import Angles, fields_at_points, in_pairs, points_to_modes
from celltrain.runtime import constant

Points = Float[Array, "point 3"]
Modes = Complex[Array, "part x y z"]


class Transform(eqx.Module):
    """Transform between points and the modes of one box, for real fields.

    `box` is its size in r0 along x, y and z, `shape` the numbers of modes there.
    """

    shape: tuple[int, int, int] = eqx.field(static=True)
    tolerance: float = eqx.field(static=True)
    box: Float[Array, "3"]

    def wave_vectors(self) -> tuple[Array, Array, Array]:
        """Components kx, ky, kz, broadcastable to the shape of the modes, in 1/r0."""
        x, y, z = (
            2.0 * math.pi * (jnp.arange(count) - count // 2) / self.box[i]
            for i, count in enumerate(self.shape)
        )
        return x[:, None, None], y[None, :, None], z[None, None, :]

    def analyse(self, points: Points, strengths: Float[Array, "point part"]) -> Modes:
        """Modes of strengths at the points, differentiable in both."""
        return _analysed(self, points, strengths)

    def synthesise(self, points: Points, modes: Modes) -> Float[Array, "point part"]:
        """Fields at the points, differentiable in both."""
        return _synthesised(self, points, modes)

    def _angles(self, points: Points) -> Angles:
        parts = points / self.box
        x, y, z = (2.0 * math.pi * parts[:, i] for i in range(3))
        return x, y, z - 2.0 * math.pi * jnp.round(parts[:, 2])

    def _forth(self, points: Points, strengths: Float[Array, "point part"]) -> Modes:
        count = strengths.shape[1]
        pairs = in_pairs(strengths.T)
        modes = points_to_modes(self.shape, pairs, self._angles(points), self.tolerance)
        # Transforms of real strengths a, b from that of a + i b, by their symmetry under k -> -k.
        mirrored = jnp.conj(modes[:, ::-1, ::-1, ::-1])
        both = jnp.stack([0.5 * (modes + mirrored), -0.5j * (modes - mirrored)], axis=1)
        return both.reshape(-1, *self.shape)[:count]

    def _back(self, points: Points, modes: Modes) -> Float[Array, "point part"]:
        return fields_at_points(modes, self._angles(points), self.tolerance).T


@jax.custom_jvp
def _analysed(transform: Transform, points: Points, strengths: Array) -> Array:
    return transform._forth(points, strengths)


@_analysed.defjvp
def _analysed_jvp(primals, tangents):  # type: ignore[no-untyped-def]
    transform, points, strengths = primals
    _, d_points, d_strengths = tangents
    parts = strengths.shape[1]
    dipoles = d_points[:, :, None] * strengths[:, None, :]
    moved = transform._forth(
        points, jnp.concatenate([d_strengths, dipoles.reshape(-1, 3 * parts)], axis=1)
    )
    moved = moved.reshape(4, parts, *transform.shape)
    change = moved[0]
    for component, part in zip(transform.wave_vectors(), moved[1:], strict=True):
        change = change - 1j * component * part
    return _analysed(transform, points, strengths), change


@jax.custom_jvp
def _synthesised(transform: Transform, points: Points, modes: Array) -> Array:
    return transform._back(points, modes)


@_synthesised.defjvp
def _synthesised_jvp(primals, tangents):  # type: ignore[no-untyped-def]
    transform, points, modes = primals
    _, d_points, d_modes = tangents
    slopes = [1j * component * modes for component in transform.wave_vectors()]
    found = transform._back(points, jnp.concatenate([d_modes, *slopes]))
    change, *gradient = jnp.split(found, 4, axis=1)
    for i, along in enumerate(gradient):
        change = change + along * d_points[:, i, None]
    return _synthesised(transform, points, modes), change


def transform(split: EwaldSplit, width: float, period: float, tolerance: float) -> Transform:
    """Transform for points in a box (sizes in r0)."""
    across, along = (
        2 * math.ceil(split.largest_wave_number * length / (2.0 * math.pi)) + 1
        for length in (width, period)
    )
    box = constant(np.array([width, width, period], dtype=float))
    return Transform((across, across, along), tolerance, box)
