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
from jaxtyping import Bool, Float, Int
from scipy.spatial import cKDTree

from celltrain.compiled.facing_loop import BEND
from celltrain.harmonics import Shapes, real_harmonics, surface_points
from celltrain.proximity.boxes import close_boxes, image_shift
from celltrain.proximity.nearest import NearestPointSearch, nearest_point_search, nearest_points
from celltrain.proximity.own_sides import OwnSidesSearch, own_sides_search
from celltrain.proximity.surface_grid import SurfaceGrid, Vectors, surface_grid
from celltrain.proximity.walls import Wall

Points = Float[np.ndarray, "point 3"]

# Rings of the grids, over the degree of the shapes.
COARSE = 3
FINE = 6
# Largest length on a membrane, over that on the unit sphere, that the search allows for.
STRETCH = 2.0


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
class _Side:
    """Candidates of one cell near another: grid points, places as seen by the other, guesses."""

    cell: int
    other: int
    node: Int[np.ndarray, " point"]
    points: Points
    guess: Int[np.ndarray, " point"]


@dataclass(frozen=True)
class FilmGrid:
    """The two grids, for shapes with the harmonics below one degree.

    `parent` is the nearest point of the coarse one to each of the fine one.
    """

    degree: int
    coarse: SurfaceGrid
    fine: SurfaceGrid
    parent: Int[np.ndarray, " point"]
    search: NearestPointSearch
    own_sides: OwnSidesSearch

    def find(self, shapes: Shapes, *, within: float, period: float) -> FilmPoints:
        """All points less than `within` (r0) from another cell, or another part of their own.

        Cells recur with the period.
        """
        surfaces = self.coarse.surfaces(shapes)
        found = self._between_cells(shapes, surfaces.points, within, period)
        for cell, sides in self.own_sides.find(shapes, surfaces, within=within):
            number = np.full_like(sides.node, cell)
            found.append(
                FilmPoints(number, number, sides.node, sides.gap, sides.direction, sides.nearest)
            )
        parts = ([getattr(each, name.name) for each in found] for name in fields(FilmPoints))
        return FilmPoints(*(np.concatenate(each) for each in parts))

    def _between_cells(
        self, shapes: Shapes, coarse: Vectors, within: float, period: float
    ) -> list[FilmPoints]:
        sides = self._sides(shapes, coarse, within, period)
        empty = np.zeros(0, dtype=int)
        cell = np.concatenate([empty, *(np.full_like(side.node, side.cell) for side in sides)])
        other = np.concatenate([empty, *(np.full_like(side.node, side.other) for side in sides)])
        node = np.concatenate([empty, *(side.node for side in sides)])
        guess = np.concatenate([empty, *(side.guess for side in sides)])
        points = np.concatenate([np.zeros((0, 3)), *(side.points for side in sides)])
        guesses = self.fine.angles[guess]
        angles, distance = nearest_points(self.search, points, other, shapes, guesses)
        kept = distance < within
        nearest = real_harmonics(self.degree, *angles[kept].T)
        away = points[kept] - np.einsum("pk,pik->pi", nearest, shapes[other[kept]])
        return [
            FilmPoints(
                cell=cell[kept],
                other=other[kept],
                node=node[kept],
                distance=distance[kept],
                direction=away / distance[kept, None],
                nearest=nearest,
            )
        ]

    def at_wall(self, shapes: Shapes, *, within: float, wall: Wall) -> WallPoints:
        """All points less than `within` (r0) from the wall."""
        least = wall.distance(surface_points(shapes, self.coarse.values)).min(axis=1)
        close = np.flatnonzero(least < within + _spacing(COARSE * self.degree))
        points = surface_points(shapes[close], self.fine.values)
        distance = wall.distance(points)
        place, node = np.nonzero(distance < within)
        inward = wall.inward(points[place, node])
        return WallPoints(close[place], node, distance[place, node], inward)

    def _sides(self, shapes: Shapes, points: Vectors, within: float, period: float) -> list[_Side]:
        reach = within + 2.0 * _spacing(COARSE * self.degree)
        trees: dict[int, cKDTree] = {}
        sides = []
        for first, second, image in close_boxes(points, within=reach, period=period):
            shift = image_shift(image, period)
            for cell in {first, second} - trees.keys():
                trees[cell] = cKDTree(points[cell])
            close = (
                np.isfinite(_query(points[first] - shift, trees[second], reach)[0]),
                np.isfinite(_query(points[second] + shift, trees[first], reach)[0]),
            )
            if close[0].any():
                sides += self._candidates(shapes, (first, second), close, shift, within)
        return sides

    def _candidates(
        self,
        shapes: Shapes,
        cells: tuple[int, int],
        close: tuple[Bool[np.ndarray, " node"], Bool[np.ndarray, " node"]],
        shift: Float[np.ndarray, "3"],
        within: float,
    ) -> list[_Side]:
        """Points of the fine grid that can be within the distance, of both cells."""
        first, second = cells
        nodes = [np.flatnonzero(each[self.parent]) for each in close]
        here = self.fine.values[nodes[0]] @ shapes[first].T - shift
        there = self.fine.values[nodes[1]] @ shapes[second].T
        bound = float(np.hypot(within, _spacing(FINE * self.degree)))
        found = []
        for side, points, others in ((0, here, there), (1, there, here)):
            distance, index = _query(points, cKDTree(others), bound)
            number = np.flatnonzero(np.isfinite(distance))
            index = index[number]
            guess = nodes[1 - side][index]
            # The distance from the plane that touches the surface at the nearest point of the grid
            # is right to half the curvature times the square of the distance along it.
            down, around = self.fine.tables[1:, guess] @ shapes[cells[1 - side]].T
            normal = np.cross(down, around)
            away = points[number] - others[index]
            height = np.abs(np.sum(normal * away, axis=1)) / np.linalg.norm(normal, axis=1)
            likely = height < within + BEND * (distance[number] ** 2 - height**2)
            number, guess = number[likely], guess[likely]
            found.append(
                _Side(
                    cell=cells[side],
                    other=cells[1 - side],
                    node=nodes[side][number],
                    points=points[number] + (0.0 if side == 0 else shift),
                    guess=guess,
                )
            )
        return found


def _spacing(order: int) -> float:
    """Largest distance of a membrane's point from the nearest one of a grid, in r0."""
    return float(STRETCH * np.sqrt(0.5) * np.pi / order)


def _query(
    points: Points, tree: cKDTree, reach: float
) -> tuple[Float[np.ndarray, " point"], Int[np.ndarray, " point"]]:
    """Distance to the nearest point of the tree, infinite beyond the reach, and its number."""
    distance, index = tree.query(points, distance_upper_bound=reach)
    return np.asarray(distance), np.asarray(index)


@lru_cache(maxsize=4)
def film_grid(degree: int) -> FilmGrid:
    """Grids for the harmonics below `degree`."""
    search = nearest_point_search(degree)
    own = own_sides_search(
        surface_grid(degree, COARSE * degree), surface_grid(degree, FINE * degree), search
    )
    return FilmGrid(degree, own.coarse, own.fine, own.parent, search, own)
