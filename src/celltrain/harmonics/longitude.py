"""Coefficients of functions on the sphere turned about its axis, in JAX."""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

import celltrain.runtime  # noqa: F401
from celltrain.harmonics.basis import degrees_and_orders
from celltrain.harmonics.shapes import degree_of


def turns(
    angles: Float[Array, " angle"], degree: int
) -> tuple[Float[Array, "angle coefficient"], Float[Array, "angle coefficient"]]:
    """cos(m a) and sin(m a) for every coefficient's order m, negative for the sines."""
    _, order = degrees_and_orders(degree)
    turn = angles[:, None] * jnp.arange(degree)
    # By a matrix that puts each order in its places: what XLA can merge with the cosines it
    # computes anew for each coefficient and each function.
    places = np.abs(order) == np.arange(degree)[:, None]
    return jnp.cos(turn) @ places.astype(float), jnp.sin(turn) @ (places * np.sign(order))


def partners(
    coefficients: Float[Array, "*batch coefficient"],
) -> Float[Array, "*batch coefficient"]:
    """The coefficients of opposite order, cosines for sines."""
    n, order = degrees_and_orders(degree_of(coefficients))
    return coefficients[..., n * n + n - order]


def shift_longitude(
    coefficients: Float[Array, "*batch coefficient"], angles: Float[Array, " angle"]
) -> Float[Array, "angle *batch coefficient"]:
    """Coefficients of x(theta, phi + angle), for each angle."""
    # cos(m (phi + a)) = cos(m a) cos(m phi) - sin(m a) sin(m phi), and the like for the sine.
    shape = (-1,) + (1,) * (coefficients.ndim - 1) + coefficients.shape[-1:]
    found = turns(angles, degree_of(coefficients))
    cosine, sine = (each.reshape(shape) for each in found)
    return cosine * coefficients + sine * partners(coefficients)


def unshift_longitude(
    functionals: Float[Array, "*batch angle coefficient"], angles: Float[Array, " angle"]
) -> Float[Array, "*batch angle coefficient"]:
    """Transpose of `shift_longitude`: what acts on x(theta, phi + angle), as acting on x."""
    cosine, sine = turns(angles, degree_of(functionals))
    return cosine * functionals - sine * partners(functionals)


def turn_longitude(
    coefficients: Float[Array, "pair channel coefficient"], angles: Float[Array, " pair"]
) -> Float[Array, "pair channel coefficient"]:
    """Coefficients of x(theta, phi + angle), an angle for each pair."""
    cosine, sine = turns(angles, degree_of(coefficients))
    return cosine[:, None] * coefficients + sine[:, None] * partners(coefficients)
