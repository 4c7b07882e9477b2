"""Compiled loops over pairs of points of surfaces that are close to each other.

Points of a surface are in blocks of neighbours, one block after the other; blocks whose spheres are
apart are passed by.
"""

import math
from typing import Any

import numpy as np
from numba import njit

from celltrain.compiled.kernels import cross, dot, squared
from celltrain.parts import FAST, part

#: Half the largest curvature of a membrane, 1/r0, that a search for what is near allows for.
BEND = 3.0


@part()
def spheres(points: Any, starts: Any) -> Any:
    """Middle and radius of each block of points [cell, point, 3]."""
    cells, blocks = points.shape[0], starts.size - 1
    middle, radius = np.empty((cells, blocks, 3)), np.empty((cells, blocks))
    for cell in range(cells):
        for block in range(blocks):
            some = points[cell, starts[block] : starts[block + 1]]
            radius[cell, block] = _sphere(some, middle[cell, block])
    return middle, radius


@part()
def _sphere(points: Any, middle: Any) -> float:
    """Radius of the sphere about the mean of points [point, 3], which is written to `middle`."""
    middle[:] = 0.0
    for p in range(points.shape[0]):
        for i in range(3):
            middle[i] += points[p, i] / points.shape[0]
    square = 0.0
    for p in range(points.shape[0]):
        square = max(square, squared(apart(points[p], middle)))
    return math.sqrt(square)


@part(inline="always")
def apart(a: Any, b: Any) -> Any:
    """The vector from b to a."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@part()
def _near(middle: Any, radius: Any, pairs: Any, period: float, reach: float) -> Any:
    """Which blocks [cell, block] are within the reach of one of the other cell of a pair."""
    near = np.zeros(radius.shape, dtype=np.bool_)
    for pair in range(pairs.shape[0]):
        first, second = pairs[pair, 0], pairs[pair, 1]
        shift = _shift(pairs[pair, 2], period)
        for one in range(radius.shape[1]):
            for other in range(radius.shape[1]):
                bound = radius[first, one] + radius[second, other] + reach
                if _squared_apart(middle[first, one], middle[second, other], shift) < bound * bound:
                    near[first, one] = near[second, other] = True
    return near


@part()
def _shift(image: int, period: float) -> float:
    return image * period if image != 0 else 0.0


@part()
def _squared_apart(a: Any, b: Any, shift: float) -> float:
    """Square of the distance of a from b, which is displaced along z."""
    return squared((a[0] - b[0], a[1] - b[1], a[2] - b[2] - shift))


@part(fastmath=FAST)
def _at(table: Any, shape: Any, place: Any) -> None:
    """What harmonics [k] at a point make of a shape [3, k]."""
    x = y = z = 0.0
    for k in range(table.size):
        x += table[k] * shape[0, k]
        y += table[k] * shape[1, k]
        z += table[k] * shape[2, k]
    place[0], place[1], place[2] = x, y, z


@part()
def _likely(away: Any, square: float, normal: Any, within: float) -> bool:
    """Whether a point may be within a distance of a surface, from its nearest point of a grid.

    Its distance from the plane that touches the surface there is right to half the curvature times
    the square of the distance along it.
    """
    height = abs(dot(away, normal)) / math.sqrt(squared(normal))
    return height < within + BEND * (square - height * height)


@njit(cache=True, nogil=True, error_model="numpy")
def close_on_host(
    coarse: Any,
    coarse_starts: Any,
    tables: Any,
    starts: Any,
    shapes: Any,
    pairs: Any,
    period: float,
    reaches: tuple[float, float, float],
) -> Any:
    """Points of a fine grid that may be within a distance of another cell.

    **Arguments:** `coarse`: points [cell, point, 3] of a coarse grid, which tell which blocks are
    near; `tables`: harmonics of the fine one's points and their slopes, [3, point, k]; `pairs`:
    numbers of two cells, and by how many periods the second is displaced; `reaches`: of blocks, of
    points of the fine grid, and the distance itself.

    **Returns:** cell, other cell, number of the point, of the nearest one of the other, [found, 4];
    places, as the other cell sees them, [found, 3].
    """
    reach, bound, within = reaches
    middle, radius = spheres(coarse, coarse_starts)
    near = _near(middle, radius, pairs, period, reach)
    cells, blocks = near.shape
    # The points of all blocks that are near another, one after the other.
    begins = np.full((cells, blocks), -1)
    count = 0
    for cell in range(cells):
        for block in range(blocks):
            if near[cell, block]:
                begins[cell, block] = count
                count += starts[block + 1] - starts[block]
    node, place = np.empty(count, np.int64), np.empty((count, 3))
    for block in range(blocks):
        # Cell by cell for each point: its harmonics are read once.
        for k in range(starts[block], starts[block + 1]):
            for cell in range(cells):
                if near[cell, block]:
                    p = begins[cell, block] + k - starts[block]
                    node[p] = k
                    _at(tables[0, k], shapes[cell], place[p])
        for cell in range(cells):
            if near[cell, block]:
                # Of the fine grid's points, which are known now.
                begin = begins[cell, block]
                some = place[begin : begin + starts[block + 1] - starts[block]]
                radius[cell, block] = _sphere(some, middle[cell, block])

    found, seen, total = np.empty((count + 1, 4), np.int64), np.empty((count + 1, 3)), 0
    square, nearest = np.empty((2, count)), np.empty((2, count), np.int64)
    down, around = np.empty(3), np.empty(3)
    for pair in range(pairs.shape[0]):
        first, second = pairs[pair, 0], pairs[pair, 1]
        shift = _shift(pairs[pair, 2], period)
        square[:] = bound * bound
        nearest[:] = -1
        for one in range(blocks):
            for other in range(blocks):
                if begins[first, one] < 0 or begins[second, other] < 0:
                    continue
                most = radius[first, one] + radius[second, other] + bound
                if _squared_apart(middle[first, one], middle[second, other], shift) >= most * most:
                    continue
                begin = begins[second, other]
                end = begin + starts[other + 1] - starts[other]
                most = radius[second, other] + bound
                for k in range(starts[one + 1] - starts[one]):
                    p = begins[first, one] + k
                    if _squared_apart(place[p], middle[second, other], shift) >= most * most:
                        continue
                    for q in range(begin, end):
                        apart = _squared_apart(place[p], place[q], shift)
                        if apart < square[0, p]:
                            square[0, p], nearest[0, p] = apart, q
                        if apart < square[1, q]:
                            square[1, q], nearest[1, q] = apart, p
        for side in range(2):
            cell, facing = (first, second) if side == 0 else (second, first)
            by = -shift if side == 0 else shift
            for p in range(count):
                q = nearest[side, p]
                if q < 0:
                    continue
                _at(tables[1, node[q]], shapes[facing], down)
                _at(tables[2, node[q]], shapes[facing], around)
                away = (
                    place[p, 0] - place[q, 0],
                    place[p, 1] - place[q, 1],
                    place[p, 2] - place[q, 2] + by,
                )
                if not _likely(away, square[side, p], cross(down, around), within):
                    continue
                if total == len(found):
                    found, seen = _longer(found), _longer(seen)
                found[total, 0], found[total, 1] = cell, facing
                found[total, 2], found[total, 3] = node[p], node[q]
                seen[total, 0], seen[total, 1] = place[p, 0], place[p, 1]
                seen[total, 2] = place[p, 2] + by
                total += 1
    return found[:total], seen[:total]


@part()
def _longer(rows: Any) -> Any:
    """The same rows and room for as many more."""
    longer = np.empty((2 * rows.shape[0], rows.shape[1]), rows.dtype)
    for row in range(rows.shape[0]):
        for column in range(rows.shape[1]):
            longer[row, column] = rows[row, column]
    return longer
