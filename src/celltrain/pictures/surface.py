"""Cells as closed quadrilateral meshes, for drawing only."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float, Int

from celltrain.harmonics import real_harmonics


@dataclass(frozen=True)
class Mesh:
    """Mesh of the unit sphere, to which any cell of the same degree can be mapped.

    Attributes:
        harmonics: values of the real harmonics at the vertices.
        faces: vertex numbers of each quadrilateral, counter-clockwise seen from outside. Those
            at the poles have two equal corners.
        latitudes, longitudes: numbers of faces from pole to pole and around the axis.
    """

    harmonics: Float[np.ndarray, "vertex coefficient"]
    faces: Int[np.ndarray, "face 4"]
    latitudes: int
    longitudes: int

    def vertices(
        self, coefficients: Float[np.ndarray, "*cell 3 coefficient"]
    ) -> Float[np.ndarray, "*cell vertex 3"]:
        """Positions (r0) of the vertices of cells with the given shape coefficients."""
        return np.swapaxes(coefficients @ self.harmonics.T, -1, -2)

    def normals(
        self, vertices: Float[np.ndarray, "*cell vertex 3"]
    ) -> Float[np.ndarray, "*cell vertex 3"]:
        """Outward unit normals at the vertices, from central differences along the grid."""
        rows = self.latitudes + 1
        grid = vertices.reshape(*vertices.shape[:-2], rows, self.longitudes, 3)
        south = np.gradient(grid, axis=-3)
        east = np.roll(grid, -1, axis=-2) - np.roll(grid, 1, axis=-2)
        normal = np.cross(south, east)
        # At a pole all longitudes are one point: it gets the mean normal of the ring beside it.
        for pole, ring in ((0, 1), (-1, -2)):
            mean = normal[..., ring, :, :].mean(axis=-2, keepdims=True)
            normal[..., pole, :, :] = mean
        length = np.linalg.norm(normal, axis=-1, keepdims=True)
        return (normal / np.maximum(length, 1e-300)).reshape(vertices.shape)


@lru_cache(maxsize=8)
def surface(degree: int, latitudes: int = 56, longitudes: int = 72) -> Mesh:
    """The mesh for cells of the given harmonic degree, `latitudes * longitudes` faces."""
    theta = np.linspace(0.0, np.pi, latitudes + 1)
    phi = 2 * np.pi * np.arange(longitudes) / longitudes
    row = np.repeat(np.arange(latitudes), longitudes)
    column = np.tile(np.arange(longitudes), latitudes)
    after = (column + 1) % longitudes
    faces = np.stack(
        [
            row * longitudes + column,
            (row + 1) * longitudes + column,
            (row + 1) * longitudes + after,
            row * longitudes + after,
        ],
        axis=-1,
    )
    values = real_harmonics(degree, np.repeat(theta, longitudes), np.tile(phi, latitudes + 1))
    return Mesh(np.asarray(values), faces, latitudes, longitudes)
