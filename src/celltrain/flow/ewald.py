"""Ewald (Hasimoto) splitting of the periodic Stokeslet, and its near kernel.

    G(d) = G_near(d) + G_far(d),   d = x - y,
    G_near = A I + C d d,   A = E - h,   C = (E + h)/r^2,
    E = erfc(xi r)/r,   h = 2 xi/sqrt(pi) exp(-xi^2 r^2),
    G_far  = (8 pi/V) sum_{k != 0} (1 + k^2/4 xi^2) exp(-k^2/4 xi^2) (k^2 I - k k)/k^4 exp(i k.d).

Their sum does not depend on xi (Hasimoto 1959). The box is periodic over the train's period in z
and over `width` across; `width` exceeds the tube's diameter by the near kernel's range, so that the
near kernel never reaches an image across. What the images across do to the flow is a regular flow
inside the tube, which the tube's wall removes.
"""

import math

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

import celltrain.runtime  # noqa: F401


class EwaldSplit(eqx.Module):
    """Numbers of the splitting; `cutoff` and `tolerance` fix the rest.

    `parameter` is xi; beyond `cutoff` the near kernel is below `tolerance`, and so is the far
    kernel's spectrum beyond `largest_wave_number`.
    """

    parameter: float = eqx.field(static=True)
    cutoff: float = eqx.field(static=True)
    width: float = eqx.field(static=True)
    largest_wave_number: float = eqx.field(static=True)


def ewald_split(tube_diameter: float, cutoff: float, tolerance: float) -> EwaldSplit:
    """Splitting with near range `cutoff` (r0) and relative truncation `tolerance`."""
    decay = math.sqrt(-math.log(tolerance))
    parameter = decay / cutoff
    return EwaldSplit(parameter, cutoff, tube_diameter + cutoff, 2.0 * parameter * decay)


def near_scalars(
    square: Float[Array, "..."], parameter: float
) -> tuple[Float[Array, "..."], Float[Array, "..."]]:
    """A and C of the near kernel A I + C d d, from r^2."""
    inverse = jax.lax.rsqrt(square)
    radius = square * inverse
    screened = jax.lax.erfc(parameter * radius) * inverse
    gauss = (2.0 * parameter / math.sqrt(math.pi)) * jnp.exp(-(parameter**2) * square)
    return screened - gauss, (screened + gauss) * inverse * inverse


def near_slopes(
    square: Float[Array, "..."], parameter: float
) -> tuple[Float[Array, "..."], Float[Array, "..."]]:
    """A'/r and C'/r of the near kernel, from r^2.

    A'/r = -(E + h)/r^2 + 2 xi^2 h,   C'/r = -3 (E + h)/r^4 - 2 xi^2 h/r^2.
    """
    inverse = jax.lax.rsqrt(square)
    screened = jax.lax.erfc(parameter * square * inverse) * inverse
    gauss = (2.0 * parameter / math.sqrt(math.pi)) * jnp.exp(-(parameter**2) * square)
    core = (screened + gauss) * inverse * inverse
    tail = 2.0 * parameter**2 * gauss
    return tail - core, -(3.0 * core + tail) * inverse * inverse


def far_velocity_modes(
    force_modes: tuple[Array, Array, Array],
    wave_vectors: tuple[Array, Array, Array],
    volume: Float[Array, ""],
    parameter: float,
) -> tuple[Array, Array, Array]:
    """Far part of int G F dOmega/(8 pi) per wave vector, from the transform of the force.

    The mode k = 0 is left out: the fluid outside the tube's wall balances the net force.
    """
    kx, ky, kz = wave_vectors
    square = kx * kx + ky * ky + kz * kz
    safe = jnp.where(square > 0.0, square, 1.0)
    quarter = safe / (4.0 * parameter**2)
    symbol = jnp.where(square > 0.0, (1.0 + quarter) * jnp.exp(-quarter) / (volume * safe), 0.0)
    fx, fy, fz = force_modes
    along = (kx * fx + ky * fy + kz * fz) / safe
    return symbol * (fx - kx * along), symbol * (fy - ky * along), symbol * (fz - kz * along)
