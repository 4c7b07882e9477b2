"""Points of membranes on a grid of the parameter sphere, with area elements there."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from celltrain.harmonics import Shapes
from celltrain.harmonics.grid import sphere_grid
from celltrain.harmonics.tables import harmonic_tables

Vectors = Float[np.ndarray, "cell point 3"]


class Surfaces(NamedTuple):
    """What a grid has of shapes: points, outward area elements, and stretches.

    Area elements are by the area on the parameter sphere. A cell's stretch is the largest length on
    its membrane for one on the sphere, along the coordinates.
    """

    points: Vectors
    areas: Vectors
    stretch: Float[np.ndarray, " cell"]


@dataclass(frozen=True)
class SurfaceGrid:
    """A grid of `order` rings for the harmonics below `degree`; `weights` of solid angle."""

    degree: int
    order: int
    angles: Float[np.ndarray, "point 2"]
    weights: Float[np.ndarray, " point"]

    @cached_property
    def tables(self) -> Float[np.ndarray, "3 point coefficient"]:
        """Harmonics at the points, their slopes down the colatitude and, over the sine, around.

        They are made when they are first wanted: those of a fine grid take long and much memory.
        """
        theta, phi = self.angles.T
        tables = harmonic_tables(self.degree, theta, phi)
        around = np.asarray(tables.d_phi) / np.sin(theta)[:, None]
        return np.stack([tables.value, tables.d_theta, around])

    @property
    def values(self) -> Float[np.ndarray, "point coefficient"]:
        """The harmonics at the points."""
        return self.tables[0]

    @property
    def step(self) -> float:
        """Angle between neighbouring rings, and at the equator between points of a ring."""
        return math.pi / self.order

    def spacing(self, stretch: Float[np.ndarray, " cell"]) -> Float[np.ndarray, " cell"]:
        """Largest distance of a membrane's point from the nearest one of the grid, r0.

        Half a diagonal. **Arguments:** `stretch`: those of the cells.
        """
        return math.sqrt(0.5) * stretch * self.step

    def surfaces(self, shapes: Shapes, nodes: Int[np.ndarray, " point"] | None = None) -> Surfaces:
        """The surfaces of shapes. **Arguments:** `nodes`: numbers of the points, if not all."""
        tables = self.tables if nodes is None else np.take(self.tables, nodes, axis=1)
        # One product of matrices: many small ones take four times as long.
        every = tables.reshape(-1, tables.shape[2]) @ shapes.reshape(-1, shapes.shape[2]).T
        by_cell = np.moveaxis(every.reshape(3, tables.shape[1], len(shapes), 3), 2, 1)
        # Of one layout, for which loops are compiled.
        points, down, around = np.ascontiguousarray(by_cell)
        squares = (np.max(np.sum(each**2, axis=-1), axis=1) for each in (down, around))
        return Surfaces(points, np.cross(down, around), np.sqrt(np.maximum(*squares)))

    def reordered(self, order: Int[np.ndarray, " point"]) -> "SurfaceGrid":
        """The same points in another order."""
        return SurfaceGrid(self.degree, self.order, self.angles[order], self.weights[order])


def surface_grid(degree: int, order: int) -> SurfaceGrid:
    """The grid of `order` rings for the harmonics below `degree`."""
    grid = sphere_grid(1, order)
    angles = np.stack(grid.points(), axis=-1)
    return SurfaceGrid(degree, order, angles, np.asarray(grid.weights))
