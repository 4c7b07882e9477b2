"""Quadrature on the unit sphere: product grids."""

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from celltrain.harmonics.basis import real_harmonics
from celltrain.harmonics.nodes import gauss_colatitudes
from celltrain.runtime import constant


class SphereGrid(eqx.Module):
    """Gauss-Legendre colatitudes times uniform longitudes, with the harmonics on them.

    Points are ordered ring by ring. `weights` are those of solid angle; they integrate harmonics
    of degree up to 2 * rings - 1 exactly, which makes `projection`, from values on the grid to
    coefficients, exact for them.
    """

    rings: int = eqx.field(static=True)
    azimuths: int = eqx.field(static=True)
    theta: Float[Array, " ring"]
    phi: Float[Array, " azimuth"]
    weights: Float[Array, " point"]
    values: Float[Array, "point coefficient"]
    # Kept: XLA multiplies by a matrix that it transposes on the way at half the speed.
    projection: Float[Array, "coefficient point"]

    def points(self) -> tuple[np.ndarray, np.ndarray]:
        """Colatitude and longitude of every point, each [ring * azimuth]."""
        theta, phi = np.meshgrid(np.asarray(self.theta), np.asarray(self.phi), indexing="ij")
        return theta.ravel(), phi.ravel()


def sphere_grid(degree: int, order: int) -> SphereGrid:
    """Grid of `order` rings with 2 * order azimuths, with the harmonics below `degree`."""
    theta, gauss = gauss_colatitudes(order)
    phi = np.arange(2 * order) * np.pi / order
    all_theta, all_phi = np.repeat(theta, 2 * order), np.tile(phi, order)
    weights = np.repeat(gauss, 2 * order) * np.pi / order
    values = real_harmonics(degree, all_theta, all_phi)
    return SphereGrid(
        rings=order,
        azimuths=2 * order,
        theta=constant(theta),
        phi=constant(phi),
        weights=constant(weights),
        values=constant(values),
        projection=constant(np.ascontiguousarray((values * weights[:, None]).T)),
    )
