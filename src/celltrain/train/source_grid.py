"""Samples of the densities on the cells, as the sums over sources take them."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from celltrain.compiled.kernels import SYMMETRIC
from celltrain.flow import Sources
from celltrain.flow.sources import Surface
from celltrain.harmonics.grid import SphereGrid, sphere_grid
from celltrain.harmonics.jax_shapes import JaxShapes
from celltrain.harmonics.tables import harmonic_tables
from celltrain.runtime import constant


class SourceGrid(eqx.Module):
    """A product grid on the parameter sphere of every cell.

    `tangents` are d/dtheta and (1/sin theta) d/dphi of the harmonics at its points.
    """

    grid: SphereGrid
    tangents: Float[Array, "2 point coefficient"]

    def points(self, shapes: JaxShapes) -> Float[Array, "cell ring azimuth 3"]:
        """Points of the grid on each cell."""
        points = jnp.einsum("pk,cik->cpi", self.grid.values, shapes)
        return points.reshape(shapes.shape[0], self.grid.rings, self.grid.azimuths, 3)

    def samples(self, surface: Surface, coarse: Sources | None) -> Sources:
        """Forces, or stresslets of the densities, at the points, times the weights."""
        shapes, points = surface.shapes, self.points(surface.shapes)
        weighted = self.grid.values * self.grid.weights[:, None]
        forces = stresslets = None
        if surface.forces is not None:
            forces = jnp.einsum("pk,cik->cpi", weighted, surface.forces).reshape(points.shape)
        if surface.densities is not None:
            down, across = jnp.einsum("dpk,cik->dcpi", self.tangents, shapes)
            normals = jnp.cross(down, across)
            values = jnp.einsum("pk,cik->cpi", weighted, surface.densities)
            dyads = [
                values[..., i] * normals[..., j] + values[..., j] * normals[..., i]
                for i, j in SYMMETRIC
            ]
            stresslets = jnp.stack(dyads, axis=-1).reshape(*points.shape[:3], 6)
        return Sources(points, forces, stresslets, surface, coarse)


def source_grid(degree: int, order: int) -> SourceGrid:
    """Grid of `order` rings for the harmonics below `degree`."""
    grid = sphere_grid(degree, order)
    theta, phi = grid.points()
    tables = harmonic_tables(degree, theta, phi)
    across = np.asarray(tables.d_phi) / np.sin(theta)[:, None]
    return SourceGrid(grid, constant(np.stack([np.asarray(tables.d_theta), across])))
