"""Smallest distances: from each cell to the wall, and to the nearest other cell.

Distances are taken between points of the membranes, first those of a grid, then ever finer patches
around the closest ones. So each is an upper bound. It is sharp (to about 1e-8 r0) if the closest
points of the grid lie in the right valley, which can fail where two places are nearly equally
close. Where membranes lie along each other, the points of two grids say little about where they are
closest, so points of one are compared by their distances from the other surface. Cells that cross
each other have distance 0, to about 1e-5 r0, however deep one is in the other; the distance to the
wall is negative for a cell that sticks out.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial import cKDTree

from celltrain.harmonics import (
    Shapes,
    degree_of,
    displaced_along,
    real_harmonics,
    surface_points,
    unit_vectors,
)
from celltrain.harmonics.grid import sphere_grid
from celltrain.proximity.nearest import nearest_points
from celltrain.proximity.walls import Wall

# Patches, each finer than the last one by this factor; nodes of one from its middle to its edge.
LEVELS = 10
FINER = 0.4
REACH = 2
# Points of the grid whose distances from the nearest other surface are found for each cell.
STARTS = 64

Directions = Float[np.ndarray, "cell 3"]


@dataclass(frozen=True)
class _Grid:
    """Points of the unit sphere, their harmonics, their spacing as an angle."""

    angles: Float[np.ndarray, "point 2"]
    directions: Float[np.ndarray, "point 3"]
    values: Float[np.ndarray, "point coefficient"]
    spacing: float


@lru_cache(maxsize=4)
def _grid(degree: int) -> _Grid:
    order = 2 * degree
    grid = sphere_grid(degree, order)
    angles = np.stack(grid.points(), axis=-1)
    return _Grid(
        angles=angles,
        directions=unit_vectors(*angles.T),
        values=np.asarray(grid.values),
        spacing=np.pi / order,
    )


def wall_distance(shapes: Shapes, wall: Wall) -> Float[np.ndarray, " cell"]:
    """Distance of each cell from the wall, in r0."""
    grid = _grid(degree_of(shapes))
    points = surface_points(shapes, grid.values)
    at = grid.directions[np.argmin(wall.distance(points), axis=1)]
    smallest = np.zeros(len(shapes))
    for level in range(LEVELS):
        patch = _patch(at, grid.spacing * FINER ** (level + 1))
        distance = wall.distance(_evaluate(shapes, patch))
        smallest = distance.min(axis=1)
        at = patch[np.arange(len(shapes)), np.argmin(distance, axis=1)]
    return smallest


def cell_distance(shapes: Shapes, length: float) -> Float[np.ndarray, " cell"]:
    """Distance of each cell from the nearest other membrane, in r0.

    **Arguments:** `length`: period of the whole train; images of all cells count, a cell's own too.
    If it is infinite there are none, and a cell alone is infinitely far from others.
    """
    if len(shapes) == 1 and not np.isfinite(length):
        return np.full(1, np.inf)
    grid = _grid(degree_of(shapes))
    cells = np.arange(len(shapes))
    points = surface_points(shapes, grid.values)
    closest = _closest_points(points, length)
    moved = displaced_along(shapes[closest.partner], closest.shift)
    angles, distance = nearest_points(
        points[cells[:, None], closest.points].reshape(-1, 3),
        np.repeat(cells, STARTS),
        moved,
        grid.angles[closest.partner_points.ravel()],
    )
    best = np.argmin(np.abs(distance.reshape(-1, STARTS)), axis=1)
    ours = grid.directions[closest.points[cells, best]]
    theirs = unit_vectors(*angles.reshape(-1, STARTS, 2)[cells, best].T)
    smallest = np.zeros(len(shapes))
    for level in range(LEVELS):
        size = grid.spacing * FINER ** (level + 1)
        first, second = _patch(ours, size), _patch(theirs, size)
        both = _evaluate(np.concatenate([shapes, moved]), np.concatenate([first, second]))
        here, there = both[: len(shapes)], both[len(shapes) :]
        squares = np.sum((here[:, :, None] - there[:, None]) ** 2, axis=-1)
        best = np.argmin(squares.reshape(len(shapes), -1), axis=1)
        smallest = np.sqrt(squares.reshape(len(shapes), -1)[cells, best])
        ours = first[cells, best // squares.shape[2]]
        theirs = second[cells, best % squares.shape[2]]
    return smallest


@dataclass(frozen=True)
class _Closest:
    """For each cell the nearest other one, its axial shift, and close pairs of points of both."""

    partner: Int[np.ndarray, " cell"]
    shift: Float[np.ndarray, " cell"]
    points: Int[np.ndarray, "cell start"]
    partner_points: Int[np.ndarray, "cell start"]


def _closest_points(points: Float[np.ndarray, "cell point 3"], length: float) -> _Closest:
    """Search the points of the grid, pairs of cells whose spheres are closest first."""
    cells = len(points)
    centres = points.mean(axis=1)
    reach = np.linalg.norm(points - centres[:, None], axis=-1).max(axis=1)
    recurs = bool(np.isfinite(length))
    first, second = np.triu_indices(cells, 0 if recurs else 1)
    apart = centres[first] - centres[second]
    shifts = np.zeros((len(first), 1))
    if recurs:
        images = np.round(apart[:, 2] / length)[:, None] + [-1.0, 0.0, 1.0]
        # A cell and its own image before it are the same pair as it and the one behind.
        images = np.where((first == second)[:, None], 1.0, images)
        shifts = length * images
    offset = np.repeat(apart[:, None], shifts.shape[1], axis=1)
    offset[..., 2] -= shifts
    bound = np.linalg.norm(offset, axis=-1) - (reach[first] + reach[second])[:, None]

    trees = [cKDTree(each) for each in points]
    smallest = np.full(cells, np.inf)
    partner = np.zeros(cells, dtype=int)
    close, partner_close = (np.zeros((cells, STARTS), dtype=int) for _ in range(2))
    shift = np.zeros(cells)
    for place in np.argsort(bound, axis=None, kind="stable"):
        if bound.flat[place] >= smallest.max():
            break
        pair, image = divmod(int(place), shifts.shape[1])
        p, q, move = first[pair], second[pair], shifts[pair, image]
        if bound[pair, image] >= max(smallest[p], smallest[q]):
            continue
        distance, index = trees[q].query(points[p] - [0.0, 0.0, move])
        closest = np.argsort(distance)[:STARTS]
        found, other = distance[closest[0]], index[closest]
        if found < smallest[p]:
            smallest[p], partner[p], shift[p] = found, q, move
            close[p], partner_close[p] = closest, other
        if found < smallest[q]:
            smallest[q], partner[q], shift[q] = found, p, -move
            close[q], partner_close[q] = other, closest
    return _Closest(partner, shift, close, partner_close)


def _patch(middle: Directions, spacing: float) -> Float[np.ndarray, "cell node 3"]:
    """Directions around one for each cell, on a square patch of the given spacing (an angle)."""
    away = np.where(np.abs(middle[:, 2:]) < 0.7, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    across = np.cross(away, middle)
    across /= np.linalg.norm(across, axis=-1, keepdims=True)
    along = np.cross(middle, across)
    steps = spacing * np.arange(-REACH, REACH + 1)
    u, v = (each.ravel()[:, None] for each in np.meshgrid(steps, steps))
    patch = middle[:, None] + u * across[:, None] + v * along[:, None]
    return patch / np.linalg.norm(patch, axis=-1, keepdims=True)


def _evaluate(
    shapes: Shapes, directions: Float[np.ndarray, "cell node 3"]
) -> Float[np.ndarray, "cell node 3"]:
    """Points of each cell's membrane, in r0."""
    x, y, z = np.moveaxis(directions.reshape(-1, 3), -1, 0)
    degree = degree_of(shapes)
    values = real_harmonics(degree, np.arctan2(np.hypot(x, y), z), np.arctan2(y, x))
    values = values.reshape(*directions.shape[:2], -1)
    return values @ np.swapaxes(shapes, 1, 2)
