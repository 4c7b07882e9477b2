"""Polar coordinates about the rings of a grid: values of a shape seen from each target.

The frame of a ring at colatitude theta has its pole at (theta, phi = 0). A shape's coefficients in
it are those of a rotated sphere, and values on the product grid of polar angles (alpha, beta)
follow by two small matrix products, one in each angle. Targets at other longitudes are brought to
phi = 0 by `shift_longitude`.
"""

import math
from functools import lru_cache

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from celltrain.harmonics.basis import degrees_and_orders, real_harmonics
from celltrain.harmonics.legendre import legendre_tables
from celltrain.harmonics.nodes import about_pole, gauss_colatitudes
from celltrain.runtime import constant


# Every operator of a degree needs the same few.
@lru_cache(maxsize=256)
def polar_rotation(degree: int, theta: float) -> Float[np.ndarray, "coefficient coefficient"]:
    """Matrix from coefficients to those in the frame with its pole at (theta, phi = 0)."""
    alpha, gauss = gauss_colatitudes(degree)
    beta = np.arange(2 * degree) * np.pi / degree
    all_alpha, all_beta = np.repeat(alpha, 2 * degree), np.tile(beta, degree)
    weights = np.repeat(gauss, 2 * degree) * np.pi / degree
    here = real_harmonics(degree, all_alpha, all_beta)
    there = real_harmonics(degree, *about_pole(theta, all_alpha, all_beta))
    return (here * weights[:, None]).T @ there


class PolarTables(eqx.Module):
    """Harmonics on a product grid of polar angles, as factors of each angle.

    Coefficients are arranged by order and degree, [order, n], with zeros where n < |order|.
    `latitude` and `latitude_slope` hold the Legendre functions and their derivative in alpha,
    `longitude` and `longitude_slope` the other factor and (1/sin alpha) d/dbeta of it, the 1/sin
    alpha being kept in `inverse_sine`.
    """

    place: Int[Array, "order n"]
    back: Int[Array, " coefficient"]
    latitude: Float[Array, "order radial n"]
    latitude_slope: Float[Array, "order radial n"]
    longitude: Float[Array, "order azimuthal"]
    longitude_slope: Float[Array, "order azimuthal"]
    inverse_sine: Float[Array, " radial"]

    def values(
        self, coefficients: Float[Array, "*batch coefficient"]
    ) -> Float[Array, "*batch radial azimuthal"]:
        """Values at the nodes."""
        by_order = self._by_order(coefficients, self.latitude)
        return jnp.einsum("m...r,ma->...ra", by_order, self.longitude)

    def with_tangents(
        self, coefficients: Float[Array, "*batch coefficient"]
    ) -> tuple[Array, Array, Array]:
        """Values, d/dalpha and (1/sin alpha) d/dbeta at the nodes."""
        by_order = self._by_order(coefficients, self.latitude)
        slope = self._by_order(coefficients, self.latitude_slope)
        return (
            jnp.einsum("m...r,ma->...ra", by_order, self.longitude),
            jnp.einsum("m...r,ma->...ra", slope, self.longitude),
            jnp.einsum("m...r,ma->...ra", by_order, self.longitude_slope)
            * self.inverse_sine[:, None],
        )

    def moments(
        self, weighted: Float[Array, "*batch radial azimuthal"]
    ) -> Float[Array, "*batch coefficient"]:
        """Sums over the nodes of the given numbers times each harmonic: transpose of `values`."""
        by_order = jnp.einsum("...ra,ma->...rm", weighted, self.longitude)
        arranged = jnp.einsum("...rm,mrn->...mn", by_order, self.latitude)
        flat = arranged.reshape(*arranged.shape[:-2], -1)
        return flat[..., self.back]

    def _by_order(self, coefficients: Array, latitude: Array) -> Array:
        """Sums over n, [order, *batch, radial]."""
        arranged = jnp.moveaxis(coefficients[..., self.place], -2, 0)
        return jnp.einsum("m...n,mrn->m...r", arranged, latitude)


def polar_tables(
    degree: int, alpha: Float[np.ndarray, " radial"], beta: Float[np.ndarray, " azimuthal"]
) -> PolarTables:
    """Tables for the product grid of the given polar angles, none of them 0 or pi."""
    orders = np.arange(1 - degree, degree)
    n, m = degrees_and_orders(degree)
    legendre = legendre_tables(degree, degree - 1, alpha)
    by_order = np.abs(orders)
    degrees = np.arange(degree)
    inside = degrees >= by_order[:, None]
    place = np.where(inside, degrees * degrees + degrees + orders[:, None], 0)
    back = (m + degree - 1) * degree + n
    size = np.where(orders == 0, 1.0, math.sqrt(2.0))[:, None]
    turn = by_order[:, None] * beta
    sine = (orders < 0)[:, None]
    return PolarTables(
        place=constant(place),
        back=constant(back),
        latitude=constant(legendre.value[by_order].transpose(0, 2, 1)),
        latitude_slope=constant(legendre.slope[by_order].transpose(0, 2, 1)),
        longitude=constant(size * np.where(sine, np.sin(turn), np.cos(turn))),
        longitude_slope=constant(
            size * by_order[:, None] * np.where(sine, np.cos(turn), -np.sin(turn))
        ),
        inverse_sine=constant(1.0 / np.sin(alpha)),
    )
