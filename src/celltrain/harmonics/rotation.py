"""Coefficients of a function on the sphere seen from another pole.

The frame of the pole (theta0, phi0) has the point (alpha, beta) where the given frame has
R_z(phi0) R_y(theta0) u(alpha, beta), so alpha is the angle from the pole, and beta = 0 is the
direction of growing theta. With Q a quarter turn about x, R_y(a) = Q R_z(a) Q^T: two shifts in
longitude and one constant matrix, which does not mix degrees, and its transpose. So any
angles, traced ones and poles included, cost matrix products only, and nothing is approximated.
"""

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from celltrain.harmonics.basis import degrees_and_orders, real_harmonics
from celltrain.harmonics.grid import sphere_grid
from celltrain.harmonics.longitude import turn_longitude
from celltrain.harmonics.nodes import unit_vectors
from celltrain.runtime import constant


class PoleRotation(eqx.Module):
    """Rotation of harmonics below one degree to arbitrary poles."""

    quarter: Float[Array, "coefficient coefficient"]

    def seen_from_equator(
        self,
        coefficients: Float[Array, "pair channel coefficient"],
        theta: Float[Array, " pair"],
        phi: Float[Array, " pair"],
    ) -> Float[Array, "pair channel coefficient"]:
        """Coefficients in the frame of the pole (theta, phi), its pole turned to the -y axis.

        One matrix product short of `to_pole`, whose result is this times `quarter`.
        """
        shifted = turn_longitude(coefficients, phi)
        return turn_longitude(shifted @ self.quarter.T, theta)

    def to_pole(
        self,
        coefficients: Float[Array, "pair channel coefficient"],
        theta: Float[Array, " pair"],
        phi: Float[Array, " pair"],
    ) -> Float[Array, "pair channel coefficient"]:
        """Coefficients of the same functions in the frame of the pole (theta, phi) of each pair."""
        return self.seen_from_equator(coefficients, theta, phi) @ self.quarter

    def from_pole(
        self,
        coefficients: Float[Array, "pair channel coefficient"],
        theta: Float[Array, " pair"],
        phi: Float[Array, " pair"],
    ) -> Float[Array, "pair channel coefficient"]:
        """Inverse (and transpose) of `to_pole`."""
        turned = turn_longitude(coefficients @ self.quarter.T, -theta)
        return turn_longitude(turned @ self.quarter, -phi)


def pole_rotation(degree: int) -> PoleRotation:
    """Rotations of the harmonics below `degree`."""
    grid = sphere_grid(degree, degree)
    theta, phi = grid.points()
    # Values at Q u, Q (x, y, z) = (x, z, -y): the pole z comes to y.
    x, y, z = unit_vectors(theta, phi).T
    turned = real_harmonics(degree, np.arctan2(np.hypot(x, z), -y), np.arctan2(z, x))
    n, _ = degrees_and_orders(degree)
    projection = np.asarray(grid.projection)
    quarter = projection @ turned
    return PoleRotation(constant(np.where(n[:, None] == n, quarter, 0.0)))
