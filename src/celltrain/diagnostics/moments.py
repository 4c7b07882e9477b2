"""Volume, area, centroid and second moments of a cell.

Each is an integral over the membrane, on the grid on which the membrane's energy is integrated.
The first ones are integrals over the cell by Gauss's theorem, of polynomials of degree at most
5 M - 5 on the sphere, so the usual order of 3 M makes them exact; area and shell are spectrally
accurate.
"""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from celltrain.harmonics import mean_points
from celltrain.harmonics.jax_shapes import JaxShape
from celltrain.membrane.energy import Membrane
from celltrain.membrane.geometry import surface_geometry


class CellMoments(eqx.Module):
    """Moments of one cell; x is the position, c the centroid, V the volume, A the area.

    `volume` is (1/3) int x.n dS in r0^3; `area` int dS in r0^2; `centroid` (1/V) int x dV in r0;
    `solid` (1/V) int (x - c)(x - c) dV and `shell` (1/A) int (x - c)(x - c) dS, both in r0^2. The
    latter is the tensor M of Eq. (18) of Bryngelson & Freund (2018).
    """

    volume: Float[Array, ""]
    area: Float[Array, ""]
    centroid: Float[Array, "3"]
    solid: Float[Array, "3 3"]
    shell: Float[Array, "3 3"]

    @property
    def inertia(self) -> Float[Array, "3 3"]:
        """Moment of inertia about the centroid at unit density, V (I tr G - G), in r0^5."""
        return self.volume * (jnp.eye(3) * jnp.trace(self.solid) - self.solid)


def surface_elements(
    membrane: Membrane, shape: JaxShape
) -> tuple[Float[Array, "point 3"], Float[Array, "point 3"]]:
    """Points of the membrane's grid (r0) and outward elements n dS with their weights (r0^2)."""
    geometry = surface_geometry(membrane.tables, shape)
    area = geometry.area * membrane.inverse_sine * membrane.weights
    return geometry.position, geometry.normal * area[:, None]


def cell_moments(membrane: Membrane, shape: JaxShape) -> CellMoments:
    """The moments of one cell.

    With div(x) = 3, div(x_i x) = 4 x_i and div(x_i x_j x) = 5 x_i x_j,

        V = (1/3) int x.n dS,   c_i = (1/4V) int x_i x.n dS,
        G_ij = (1/5V) int x_i x_j x.n dS   (x from c).
    """
    points, elements = surface_elements(membrane, shape)
    middle = mean_points(shape)
    # From a point inside the cell, so that a distant cell loses no digits.
    points = points - middle
    volume = jnp.sum(points * elements) / 3.0
    shift = points.T @ jnp.sum(points * elements, axis=1) / (4.0 * volume)
    points = points - shift
    outward = jnp.sum(points * elements, axis=1)
    scalar = jnp.linalg.norm(elements, axis=1)
    area = jnp.sum(scalar)
    return CellMoments(
        volume=volume,
        area=area,
        centroid=middle + shift,
        solid=(points * outward[:, None]).T @ points / (5.0 * volume),
        shell=(points * scalar[:, None]).T @ points / area,
    )
