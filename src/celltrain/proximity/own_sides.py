"""Where a membrane is within a short distance of another part of itself.

Two parts of one membrane face each other through their cell, where that is thin, or across a fold.
Their normals are opposed, which tells them from what is merely next to each other. Whether they
have crossed cannot be seen from the two alone: parts that crossed each other through the cell look
like the two sides of a fold. It is told by the winding number

    w(q) = (1/4 pi) int n.(y - q)/|y - q|^3 dA,

1 inside a cell and 0 outside: half a step of the grid beyond both parts 0 means that the cell is
between them, 1 that a fold is. At that distance the sum over the grid is right to some percent.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial import cKDTree

from celltrain.compiled.loops import FACING
from celltrain.compiled.on_host import call_on_host
from celltrain.harmonics import (
    Shape,
    Shapes,
    degree_of,
    real_harmonics,
    unit_vectors,
)
from celltrain.harmonics.grid import sphere_grid
from celltrain.proximity.nearest import nearest_points
from celltrain.proximity.surface_grid import SurfaceGrid, Surfaces

Points = Float[np.ndarray, "point 3"]
Nodes = Float[np.ndarray, "node 3"]

# Places at once of which the winding number is taken.
AT_ONCE = 64
# What distances are divided by at least.
TINY = 1e-300
# Distance of two parts below which they may have crossed.
CLOSE = 0.1


@dataclass(frozen=True)
class OwnSides:
    """Points of one membrane, each with the nearest point of the part that faces it.

    Attributes:
        node, opposite: numbers in the fine grid of the point, and of one near its nearest point.
        place: the point, r0.
        gap: distance of the two parts, r0; negative where they have crossed.
        direction: unit vector from the nearest point to the point; from the wrong side after
            crossing.
        nearest: harmonics at the nearest point.
    """

    node: Int[np.ndarray, " point"]
    opposite: Int[np.ndarray, " point"]
    place: Points
    gap: Float[np.ndarray, " point"]
    direction: Float[np.ndarray, "point 3"]
    nearest: Float[np.ndarray, "point coefficient"]


@dataclass(frozen=True)
class OwnSidesSearch:
    """The search, for shapes with the harmonics below one degree.

    The points of the coarse grid are in blocks; `block` is that of each point, and `starts` where
    each block begins, `fine_starts` in the fine one. `parent` is the point of the coarse grid
    nearest to each of the fine one.
    """

    coarse: SurfaceGrid
    starts: Int[np.ndarray, " block"]
    fine: SurfaceGrid
    fine_starts: Int[np.ndarray, " block"]
    parent: Int[np.ndarray, " point"]
    block: Int[np.ndarray, " node"]

    def find(
        self, shapes: Shapes, surfaces: Surfaces, *, within: float
    ) -> list[tuple[int, OwnSides]]:
        """Cells with parts closer than `within` (r0) to each other, and the points there.

        **Arguments:** `surfaces`: what the coarse grid has of the shapes.
        """
        points, areas, stretch = surfaces
        normals = areas / np.linalg.norm(areas, axis=-1, keepdims=True)
        far = 2.0 * self.coarse.spacing(stretch)
        distances = np.column_stack([np.full(len(far), within), far])
        facing = call_on_host(FACING, points.shape[:2], points, normals, self.starts, distances) > 0
        reach = np.hypot(within, self.fine.spacing(stretch))
        found = []
        for cell in np.flatnonzero(facing.any(axis=1)):
            node = np.flatnonzero(facing[cell, self.parent])
            sides = self._of_cell(shapes[cell], node, within, float(reach[cell]))
            if len(sides.node):
                clear = 0.5 * float(stretch[cell]) * self.coarse.step
                gap = self._crossed(sides, points[cell], areas[cell], clear)
                found.append((int(cell), replace(sides, gap=gap)))
        return found

    def _of_cell(
        self, shape: Shape, node: Int[np.ndarray, " point"], within: float, reach: float
    ) -> OwnSides:
        """Points of one cell, among those given, with the distances as across a fold."""
        (here,), (areas,), _ = self.fine.surfaces(shape[None], node)
        normals = areas / np.linalg.norm(areas, axis=1, keepdims=True)
        # Nearest with opposed normals; those of neighbours are much alike.
        tree = cKDTree(np.hstack([here, reach * normals]))
        distance, index = tree.query(
            np.hstack([here, -reach * normals]), distance_upper_bound=math.sqrt(3.0) * reach
        )
        close = np.isfinite(distance)
        guess = node[np.asarray(index)[close]]
        node, here = node[close], here[close]
        cell, guesses = np.zeros(len(node), dtype=int), self.fine.angles[guess]
        angles, signed = nearest_points(here, cell, shape[None], guesses)
        own, other, first = (
            unit_vectors(*each.T) for each in (self.fine.angles[node], angles, guesses)
        )
        # A search that came home found the point itself.
        away = np.sum(own * other, axis=1) < 0.5 * (1.0 + np.sum(own * first, axis=1))
        kept = away & (np.abs(signed) < within)
        nearest = real_harmonics(degree_of(shape), *angles[kept].T)
        apart = here[kept] - nearest @ shape.T
        return OwnSides(
            node=node[kept],
            opposite=guess[kept],
            place=here[kept],
            gap=signed[kept],
            direction=apart / np.maximum(np.abs(signed[kept]), TINY)[:, None],
            nearest=nearest,
        )

    def _crossed(
        self, sides: OwnSides, points: Nodes, areas: Nodes, clear: float
    ) -> Float[np.ndarray, " point"]:
        """Distances, negative where the parts have crossed.

        Parts that cross are close to each other somewhere, so only close points are asked. Where
        the winding numbers on the far sides differ, as where a part ends, they have not crossed.

        **Arguments:** `clear`: distance at which the winding number is taken, r0.
        """
        weighted, gap = self.coarse.weights[:, None] * areas, np.abs(sides.gap)
        close = np.flatnonzero(gap < CLOSE)
        close = close[np.argsort(gap[close], kind="stable")]
        # The closest point tells for all of its block that face the same block.
        here, there = (
            self.block[self.parent[each[close]]] for each in (sides.node, sides.opposite)
        )
        pair = here * len(self.starts) + there
        _, first, group = np.unique(pair, return_index=True, return_inverse=True)
        one = close[first]
        place, direction, apart = sides.place[one], sides.direction[one], gap[one, None]
        ahead = _winding(points, weighted, place + clear * direction)
        behind = _winding(points, weighted, place - (apart + clear) * direction)
        through = ((np.round(ahead) == 0.0) & (np.round(behind) == 0.0))[group]
        fold = ((np.round(ahead) == 1.0) & (np.round(behind) == 1.0))[group]
        signed = sides.gap[close]
        gap[close] = np.where(through, -signed, np.where(fold, signed, gap[close]))
        return gap


def _winding(points: Nodes, areas: Nodes, at: Points) -> Float[np.ndarray, " point"]:
    """The winding number of a surface, of points and area elements, around other points."""
    found = []
    for some in np.split(at, range(AT_ONCE, len(at), AT_ONCE)):
        apart = points - some[:, None]
        cube = np.sum(apart**2, axis=-1) ** 1.5
        found.append(np.sum(np.sum(apart * areas, axis=-1) / cube, axis=-1))
    return np.concatenate(found) / (4.0 * np.pi)


def own_sides_search(coarse: SurfaceGrid, fine: SurfaceGrid) -> OwnSidesSearch:
    """The search by two grids; which are put in the order of blocks."""
    # A block has the points next to one of a grid with a third as many rings.
    middles = unit_vectors(*sphere_grid(1, coarse.order // 3).points())
    block = np.asarray(cKDTree(middles).query(unit_vectors(*coarse.angles.T))[1])
    order = np.argsort(block, kind="stable")
    coarse, block = coarse.reordered(order), block[order]
    starts = np.append(np.flatnonzero(np.diff(block, prepend=-1)), len(block))
    tree = cKDTree(unit_vectors(*coarse.angles.T))
    parent = np.asarray(tree.query(unit_vectors(*fine.angles.T))[1])
    order = np.argsort(parent, kind="stable")
    fine, parent = fine.reordered(order), parent[order]
    return OwnSidesSearch(
        coarse=coarse,
        starts=starts,
        fine=fine,
        fine_starts=np.searchsorted(parent, starts),
        parent=parent,
        block=block,
    )
