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

from celltrain.harmonics.basis import (
    coefficient_index,
    degrees_and_orders,
    harmonic_tables,
    real_harmonics,
)


def about_pole(
    theta: float, alpha: Float[np.ndarray, " *point"], beta: Float[np.ndarray, " *point"]
) -> tuple[Float[np.ndarray, " *point"], Float[np.ndarray, " *point"]]:
    """Colatitude and longitude of points at the angle alpha from (theta, phi = 0).

    beta = 0 points away from the north pole, along phi = 0.
    """
    across, along, up = np.sin(alpha) * np.cos(beta), np.sin(alpha) * np.sin(beta), np.cos(alpha)
    x = np.cos(theta) * across + np.sin(theta) * up
    z = np.cos(theta) * up - np.sin(theta) * across
    return np.arctan2(np.hypot(x, along), z), np.arctan2(along, x)


# Every operator of a degree needs the same few.
@lru_cache(maxsize=256)
def polar_rotation(degree: int, theta: float) -> Float[np.ndarray, "coefficient coefficient"]:
    """Matrix from coefficients to those in the frame with its pole at (theta, phi = 0)."""
    nodes, gauss = np.polynomial.legendre.leggauss(degree)
    beta = np.arange(2 * degree) * np.pi / degree
    all_alpha, all_beta = np.repeat(np.arccos(nodes), 2 * degree), np.tile(beta, degree)
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
    on_meridian = harmonic_tables(degree, alpha, np.zeros_like(alpha))
    value, slope = np.asarray(on_meridian.value), np.asarray(on_meridian.d_theta)
    place = np.zeros((orders.size, degree), dtype=int)
    latitude, latitude_slope = np.zeros((2, orders.size, alpha.size, degree))
    back = (m + degree - 1) * degree + n
    for row, order in enumerate(orders):
        for each in range(abs(order), degree):
            place[row, each] = coefficient_index(each, int(order))
            # On the meridian the cosines are sqrt(2) (1 for order 0) and the sines vanish.
            twin = coefficient_index(each, abs(int(order)))
            scale = math.sqrt(0.5) if order else 1.0
            latitude[row, :, each] = value[:, twin] * scale
            latitude_slope[row, :, each] = slope[:, twin] * scale
    size = np.where(orders == 0, 1.0, math.sqrt(2.0))[:, None]
    turn = np.abs(orders)[:, None] * beta
    sine = (orders < 0)[:, None]
    return PolarTables(
        place=jnp.asarray(place),
        back=jnp.asarray(back),
        latitude=jnp.asarray(latitude),
        latitude_slope=jnp.asarray(latitude_slope),
        longitude=jnp.asarray(size * np.where(sine, np.sin(turn), np.cos(turn))),
        longitude_slope=jnp.asarray(
            size * np.abs(orders)[:, None] * np.where(sine, np.cos(turn), -np.sin(turn))
        ),
        inverse_sine=jnp.asarray(1.0 / np.sin(alpha)),
    )


def polar_nodes(
    radial: int, azimuthal: int
) -> tuple[
    Float[np.ndarray, " radial"],
    Float[np.ndarray, " azimuthal"],
    Float[np.ndarray, "radial azimuthal"],
]:
    """Polar angles about a point and weights of solid angle.

    The area element sin(alpha) dalpha dbeta cancels a singularity 1/alpha: Gauss-Legendre in alpha,
    uniform in beta (half a step off the plane of symmetry, so that the rule is symmetric and no
    node repeats).
    """
    nodes, gauss = np.polynomial.legendre.leggauss(radial)
    alpha = 0.5 * np.pi * (nodes + 1.0)
    beta = (np.arange(azimuthal) + 0.5) * 2.0 * np.pi / azimuthal
    weights = (0.5 * np.pi * gauss * np.sin(alpha))[:, None] * (2.0 * np.pi / azimuthal)
    return alpha, beta, np.repeat(weights, azimuthal, axis=1)
