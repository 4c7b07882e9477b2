"""Where membranes are within a short distance of each other: points, and their nearest points.

Two grids on the parameter sphere serve. The coarse one, on all cells, tells which parts of which
cells can be within the distance at all; the fine one's points there are compared with each other,
and of those that can be within the distance Newton's method finds the nearest point of the other
surface. All is done on the host: such points are few, if there are any. Parts of one membrane that
face each other are found likewise (`own_sides`).
"""

from dataclasses import dataclass, fields
from functools import lru_cache

import numpy as np
from jaxtyping import Float, Int

from celltrain.compiled.block_loops import close_on_host
from celltrain.harmonics import Shapes, real_harmonics, surface_points
from celltrain.proximity.boxes import close_boxes
from celltrain.proximity.nearest import nearest_points
from celltrain.proximity.own_sides import OwnSidesSearch, own_sides_search
from celltrain.proximity.surface_grid import SurfaceGrid, Surfaces, surface_grid
from celltrain.proximity.walls import Wall

# Rings of the grids, over the degree of the shapes.
COARSE = 3
FINE = 6


@dataclass(frozen=True)
class FilmPoints:
    """Points of membranes, each with the nearest point of what is across the film.

    Attributes:
        cell, other: the cell that a point lies on, and the other one; the same one for its image,
            or for another part of its membrane.
        node: number of the point in the fine grid.
        distance: from the other membrane, r0; negative where they cross.
        direction: unit vector from the nearest point to the point.
        nearest: harmonics at the nearest point.
    """

    cell: Int[np.ndarray, " point"]
    other: Int[np.ndarray, " point"]
    node: Int[np.ndarray, " point"]
    distance: Float[np.ndarray, " point"]
    direction: Float[np.ndarray, "point 3"]
    nearest: Float[np.ndarray, "point coefficient"]


@dataclass(frozen=True)
class WallPoints:
    """Points of cells near the wall: cell, number in the fine grid, distance (r0), direction away.

    The distance is negative beyond the wall.
    """

    cell: Int[np.ndarray, " point"]
    node: Int[np.ndarray, " point"]
    distance: Float[np.ndarray, " point"]
    direction: Float[np.ndarray, "point 3"]


@dataclass(frozen=True)
class FilmGrid:
    """The two grids, for shapes with the harmonics below one degree.

    Their points are in blocks, which begin at `coarse_starts` and `starts`.
    """

    degree: int
    coarse: SurfaceGrid
    fine: SurfaceGrid
    coarse_starts: Int[np.ndarray, " block"]
    starts: Int[np.ndarray, " block"]
    own_sides: OwnSidesSearch

    def find(
        self, shapes: Shapes, surfaces: Surfaces, *, within: float, period: float
    ) -> FilmPoints:
        """All points less than `within` (r0) from another cell, or another part of their own.

        Cells recur with the period. **Arguments:** `surfaces`: what the coarse grid has of the
        shapes.
        """
        found = [self._between_cells(shapes, surfaces, within, period)]
        for cell, sides in self.own_sides.find(shapes, surfaces, within=within):
            number = np.full_like(sides.node, cell)
            found.append(
                FilmPoints(number, number, sides.node, sides.gap, sides.direction, sides.nearest)
            )
        parts = ([getattr(each, name.name) for each in found] for name in fields(FilmPoints))
        return FilmPoints(*(np.concatenate(each) for each in parts))

    def _between_cells(
        self, shapes: Shapes, surfaces: Surfaces, within: float, period: float
    ) -> FilmPoints:
        # Of points of the fine grid across a film, and of the coarse one's nearest to them.
        stretch = surfaces.stretch
        bound = float(np.hypot(within, self.fine.spacing(stretch).max()))
        reach = bound + 2.0 * float(self.coarse.spacing(stretch).max())
        pairs = list(close_boxes(surfaces.points, within=reach, period=period))
        found, points = np.zeros((0, 4), np.int64), np.zeros((0, 3))
        if pairs:
            found, points = close_on_host(
                surfaces.points,
                self.coarse_starts,
                self.fine.tables,
                self.starts,
                np.array(shapes, float, order="C"),
                np.array(pairs, np.int64),
                float(period),
                (reach, bound, float(within)),
            )
        cell, other, node, guess = found.T
        guesses = self.fine.angles[guess]
        angles, distance = nearest_points(points, other, shapes, guesses)
        kept = distance < within
        nearest = real_harmonics(self.degree, *angles[kept].T)
        away = points[kept] - np.einsum("pk,pik->pi", nearest, shapes[other[kept]])
        return FilmPoints(
            cell=cell[kept],
            other=other[kept],
            node=node[kept],
            distance=distance[kept],
            direction=away / distance[kept, None],
            nearest=nearest,
        )

    def at_wall(
        self, shapes: Shapes, surfaces: Surfaces, *, within: float, wall: Wall
    ) -> WallPoints:
        """All points less than `within` (r0) from the wall.

        **Arguments:** `surfaces`: what the coarse grid has of the shapes.
        """
        least = wall.distance(surfaces.points).min(axis=1)
        close = np.flatnonzero(least < within + self.coarse.spacing(surfaces.stretch))
        if len(close) == 0:
            none = np.zeros(0, dtype=int)
            return WallPoints(none, none, np.zeros(0), np.zeros((0, 3)))
        points = surface_points(shapes[close], self.fine.values)
        distance = wall.distance(points)
        place, node = np.nonzero(distance < within)
        inward = wall.inward(points[place, node])
        return WallPoints(close[place], node, distance[place, node], inward)


@lru_cache(maxsize=4)
def film_grid(degree: int) -> FilmGrid:
    """Grids for the harmonics below `degree`."""
    coarse, fine = (surface_grid(degree, times * degree) for times in (COARSE, FINE))
    own = own_sides_search(coarse, fine)
    return FilmGrid(degree, own.coarse, own.fine, own.starts, own.fine_starts, own)
