"""A compiled loop over the pairs of points of one surface that face each other closely."""

import math
from typing import Any

import numpy as np
from numba import njit

from celltrain.compiled.kernels import dot, squared

#: Half the largest curvature of a membrane, 1/r0, that a search for what is near allows for.
BEND = 3.0


@njit(cache=True, error_model="numpy")
def facing_on_host(points: Any, normals: Any, starts: Any, within: float, far: Any) -> Any:
    """Which points [cell, point, 3] face a part of their own cell that may be within a distance.

    They have a point with an opposed normal (negative product) near them: not farther away than
    `within` and `far` (that of the cell), and in height, along one of the normals, not farther than
    `within` and what a surface of the largest curvature may rise. Points are in blocks, one after
    the other; blocks whose spheres are apart are passed by. **Arguments:** `starts`: number of the
    first point of each block, and at last that of all points.
    """
    cells, count, _ = points.shape
    blocks = starts.size - 1
    found = np.zeros((cells, count), dtype=np.bool_)
    middle, radius = np.empty((blocks, 3)), np.empty(blocks)
    for cell in range(cells):
        reach = within + far[cell]
        for block in range(blocks):
            first, last = starts[block], starts[block + 1]
            for i in range(3):
                middle[block, i] = points[cell, first:last, i].mean()
            square = 0.0
            for p in range(first, last):
                square = max(square, squared(_apart(points[cell, p], middle[block])))
            radius[block] = math.sqrt(square)
        for one in range(blocks):
            for other in range(one, blocks):
                bound = radius[one] + radius[other] + reach
                if squared(_apart(middle[one], middle[other])) >= bound * bound:
                    continue
                for p in range(starts[one], starts[one + 1]):
                    for q in range(starts[other], starts[other + 1]):
                        if dot(normals[cell, p], normals[cell, q]) >= 0.0:
                            continue
                        apart = _apart(points[cell, p], points[cell, q])
                        square = squared(apart)
                        if square >= reach * reach:
                            continue
                        rise, back = dot(apart, normals[cell, p]), dot(apart, normals[cell, q])
                        height = min(abs(rise), abs(back))
                        if height < within + BEND * (square - height * height):
                            found[cell, p] = found[cell, q] = True
    return found


@njit(inline="always", error_model="numpy")
def _apart(a: Any, b: Any) -> Any:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]
