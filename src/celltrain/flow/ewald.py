"""Ewald (Hasimoto) splitting of the periodic Stokeslet, and its near kernel.

    G(d) = G_near(d) + G_far(d),   d = x - y,
    G_near = A I + C d d   (`compiled.kernels`),
    G_far  = (8 pi/V) sum_{k != 0} (1 + k^2/4 xi^2) exp(-k^2/4 xi^2) (k^2 I - k k)/k^4 exp(i k.d).

Their sum does not depend on xi (Hasimoto 1959). The box is periodic over the train's period in z
and over a width across that exceeds the tube's diameter by the near kernel's range, so that the
near kernel never reaches an image across. What the images across do to the flow is a regular flow
inside the tube, which the tube's wall removes.
"""

import math
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from celltrain.compiled.kernels import stokeslet_scalars, stokeslet_slopes, stresslet_scalars
from celltrain.compiled.scaled_erfc import SCALED_ERFC, SCALED_ERFC_MIDDLE


class EwaldSplit(eqx.Module):
    """Numbers of the splitting; `cutoff` and `tolerance` fix the rest.

    `parameter` is xi; beyond `cutoff` the near kernel is below `tolerance`, and so is the far
    kernel's spectrum beyond `largest_wave_number`.
    """

    parameter: float = eqx.field(static=True)
    cutoff: float = eqx.field(static=True)
    largest_wave_number: float = eqx.field(static=True)


def ewald_split(cutoff: float, tolerance: float) -> EwaldSplit:
    """Splitting with near range `cutoff` (r0) and relative truncation `tolerance`."""
    decay = math.sqrt(-math.log(tolerance))
    parameter = decay / cutoff
    return EwaldSplit(parameter, cutoff, 2.0 * parameter * decay)


def _near_parts(
    square: Float[Array, "..."], parameter: float, cutoff: float
) -> tuple[Float[Array, "..."], Float[Array, "..."], Float[Array, "..."]]:
    """E = erfc(xi r)/r, h = 2 xi/sqrt(pi) exp(-xi^2 r^2), 0 from the cutoff on, and 1/r^2."""
    inverse = jax.lax.rsqrt(square)
    scaled = parameter * (square * inverse)
    mapped = 1.0 - (2.0 * SCALED_ERFC_MIDDLE) / (scaled + SCALED_ERFC_MIDDLE)
    polynomial = jnp.full_like(mapped, SCALED_ERFC[0])
    for coefficient in SCALED_ERFC[1:]:
        polynomial = polynomial * mapped + coefficient
    gauss = jnp.exp(-(parameter**2) * square)
    if cutoff < math.inf:
        gauss = jnp.where(square < cutoff**2, gauss, 0.0)
    return (
        polynomial * gauss * inverse,
        (2.0 * parameter / math.sqrt(math.pi)) * gauss,
        inverse * inverse,
    )


@partial(jax.custom_jvp, nondiff_argnums=(1, 2))
def near_scalars(
    square: Float[Array, "..."], parameter: float, cutoff: float = math.inf
) -> tuple[Float[Array, "..."], Float[Array, "..."]]:
    """A and C of the near kernel A I + C d d, from r^2; 0 from the cutoff on."""
    return stokeslet_scalars(*_near_parts(square, parameter, cutoff))


@near_scalars.defjvp
def _near_scalars_jvp(parameter, cutoff, primals, tangents):  # type: ignore[no-untyped-def]
    half = 0.5 * tangents[0]
    isotropic, dyadic = near_slopes(primals[0], parameter, cutoff)
    return near_scalars(primals[0], parameter, cutoff), (isotropic * half, dyadic * half)


def near_slopes(
    square: Float[Array, "..."], parameter: float, cutoff: float = math.inf
) -> tuple[Float[Array, "..."], Float[Array, "..."]]:
    """A'/r and C'/r of the near kernel, from r^2; 0 from the cutoff on."""
    parts = _near_parts(square, parameter, cutoff)
    return stokeslet_slopes(stokeslet_scalars(*parts), stresslet_scalars(*parts, parameter))


def near_stress_scalars(
    square: Float[Array, "..."], parameter: float, cutoff: float = math.inf
) -> tuple[Float[Array, "..."], Float[Array, "..."]]:
    """a and b of the near stress kernel, from r^2; 0 from the cutoff on."""
    return stresslet_scalars(*_near_parts(square, parameter, cutoff), parameter)


def far_velocity_modes(
    force_modes: tuple[Array, Array, Array] | None,
    stresslet_modes: tuple[Array, ...] | None,
    wave_vectors: tuple[Array, Array, Array],
    volume: Float[Array, ""],
    parameter: float,
) -> tuple[Array, Array, Array]:
    """Far part of the velocity per wave vector, from the transforms of what drives it.

    With g = (1 + k^2/4 xi^2) exp(-k^2/4 xi^2)/(V k^2), the force's transform F, and the transform D
    of the symmetric dyads w n + n w (xx, xy, xz, yy, yz, zz),

        u = g [(I - k k/k^2) (F - i D k) - i k tr(D)/2].

    The mode k = 0 is left out: the fluid outside the tube's wall balances the net force.
    """
    kx, ky, kz = wave_vectors
    square = kx * kx + ky * ky + kz * kz
    safe = jnp.where(square > 0.0, square, 1.0)
    quarter = safe / (4.0 * parameter**2)
    symbol = jnp.where(square > 0.0, (1.0 + quarter) * jnp.exp(-quarter) / (volume * safe), 0.0)
    nothing = jnp.zeros(())
    fx, fy, fz = force_modes if force_modes is not None else (nothing, nothing, nothing)
    trace = nothing
    if stresslet_modes is not None:
        xx, xy, xz, yy, yz, zz = stresslet_modes
        fx = fx - 1j * (xx * kx + xy * ky + xz * kz)
        fy = fy - 1j * (xy * kx + yy * ky + yz * kz)
        fz = fz - 1j * (xz * kx + yz * ky + zz * kz)
        trace = 0.5j * (xx + yy + zz)
    along = (kx * fx + ky * fy + kz * fz) / safe + trace
    return symbol * (fx - kx * along), symbol * (fy - ky * along), symbol * (fz - kz * along)
