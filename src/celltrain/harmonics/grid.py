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
    of degree up to 2 * rings - 1 exactly, which makes `projection` exact for them.
    """

    rings: int = eqx.field(static=True)
    azimuths: int = eqx.field(static=True)
    theta: Float[Array, " ring"]
    phi: Float[Array, " azimuth"]
    weights: Float[Array, " point"]
    values: Float[Array, "point coefficient"]

    @property
    def projection(self) -> Float[Array, "coefficient point"]:
        """Matrix from values on the grid to harmonic coefficients."""
        return (self.values * self.weights[:, None]).T

    def points(self) -> tuple[np.ndarray, np.ndarray]:
        """Colatitude and longitude of every point, each [ring * azimuth]."""
        theta, phi = np.meshgrid(np.asarray(self.theta), np.asarray(self.phi), indexing="ij")
        return theta.ravel(), phi.ravel()


def sphere_grid(degree: int, order: int) -> SphereGrid:
    """Grid of `order` rings with 2 * order azimuths, with the harmonics below `degree`."""
    theta, gauss = gauss_colatitudes(order)
    phi = np.arange(2 * order) * np.pi / order
    all_theta, all_phi = np.repeat(theta, 2 * order), np.tile(phi, order)
    return SphereGrid(
        rings=order,
        azimuths=2 * order,
        theta=constant(theta),
        phi=constant(phi),
        weights=constant(np.repeat(gauss, 2 * order) * np.pi / order),
        values=constant(real_harmonics(degree, all_theta, all_phi)),
    )
