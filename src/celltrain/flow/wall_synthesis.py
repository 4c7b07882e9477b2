"""The far flow at the wall's points, where the sum over wave vectors is one matrix product.

For real fields with modes u^(k),

    u(x) = Re sum_{kz >= 0} w exp(i kz z) a(kz),   w = 1 for kz = 0, else 2,
    a(kz) = sum_{kx, ky} u^(k) exp(i (kx x + ky y)),

where x, y are the same on all rings of the wall, and wave vectors +-(kx, ky) have the same cosine
and opposite sines. The sum over kz is a Fourier transform at regular points.
"""

import math

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Complex, Float

from celltrain.flow.transform import Transform
from celltrain.flow.wall import TubeWall
from celltrain.runtime import constant


class WallSynthesis(eqx.Module):
    """From modes to the points of a tube's wall, which are on `rings` rings.

    `phases`: cosines of kx x + ky y, and after them the sines, for half of the wave vectors across
    the tube, the last of which is 0.
    """

    rings: int = eqx.field(static=True)
    phases: Float[Array, "azimuth phase"]

    def fields(self, modes: Complex[Array, "part x y z"]) -> Float[Array, "ring azimuth part"]:
        """Real fields with these modes, in the order that the transform gives them."""
        parts, *across, along = modes.shape
        by_wave = modes.reshape(parts, math.prod(across), along)
        # Numbers of wave vectors are odd along each axis: backwards they are those with k -> -k.
        mirrored, count = by_wave[:, ::-1], self.phases.shape[1] // 2
        total, change = (each[:, :count] for each in (by_wave + mirrored, by_wave - mirrored))
        by_cosine = jnp.stack([total.real, total.imag])
        by_sine = jnp.stack([-change.imag, change.real])
        # Wave vectors before all else, for one matrix product.
        given = jnp.moveaxis(jnp.concatenate([by_cosine, by_sine], axis=2), 2, 0)
        real, imaginary = jnp.moveaxis(jnp.tensordot(self.phases, given, axes=1), 1, 0)
        waves = real.shape[-1]
        around = (real + 1j * imaginary) * np.where(np.arange(waves), 2.0, 1.0)
        # Waves that differ by the number of rings are the same there.
        filled = jnp.pad(around, ((0, 0), (0, 0), (0, -waves % self.rings)))
        folded = jnp.sum(filled.reshape(*around.shape[:2], -1, self.rings), axis=2)
        return jnp.transpose(jnp.fft.ifft(folded, norm="forward").real, (2, 0, 1))


def wall_synthesis(transform: Transform, wall: TubeWall) -> WallSynthesis:
    """From the modes of a transform to the points of a wall."""
    # By NumPy alone, which compiles no programs.
    kx, ky = (
        2.0 * math.pi * np.arange(-most, most + 1) / length
        for most, length in zip(transform.largest[:2], np.asarray(transform.box)[:2], strict=True)
    )
    theta = 2.0 * math.pi * np.arange(wall.azimuths) / wall.azimuths
    x, y = float(wall.radius) * np.cos(theta), float(wall.radius) * np.sin(theta)
    phase = (x[:, None, None] * kx[:, None] + y[:, None, None] * ky).reshape(len(x), -1)
    half = phase[:, : phase.shape[1] // 2 + 1]
    # Wave vector 0 is its own mirror image.
    weights = np.where(np.arange(half.shape[1]) < half.shape[1] - 1, 1.0, 0.5)
    phases = np.concatenate([weights * np.cos(half), weights * np.sin(half)], axis=1)
    return WallSynthesis(wall.rings, constant(phases))
