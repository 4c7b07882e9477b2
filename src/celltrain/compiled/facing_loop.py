"""A compiled loop for where membranes face parts of themselves (see `block_loops`)."""

from celltrain.compiled.block_loops import BEND, apart, spheres
from celltrain.compiled.call_frame import integers, numbers, result, sizes
from celltrain.compiled.kernels import dot, squared
from celltrain.compiled.loops import FACING
from celltrain.compiled.shared_work import frame_of, next_part, task


@task(FACING.name)
def _facing(work: int) -> int:
    """1 for points [cell, point, 3] that face a part of their own cell within a distance, else 0.

    They have a point with an opposed normal (negative product) near them: not farther away than
    the distance and what is allowed beyond it, and in height, along one of the normals, not farther
    than the distance and what a surface of the largest curvature may rise. Arguments: points,
    normals, number of each block's first point and at last that of all points, and the distances of
    each cell, [cell, 2]. Parts: cells.
    """
    frame = frame_of(work)
    cells, count, _ = sizes(frame, 0)
    all_points = numbers(frame, 0).reshape((cells, count, 3))
    all_normals = numbers(frame, 1).reshape((cells, count, 3))
    starts, reaches = integers(frame, 2), numbers(frame, 3).reshape((cells, 2))
    all_found = result(frame).reshape((cells, count))
    cell = next_part(work)
    while cell < cells:
        points, normals, found = all_points[cell], all_normals[cell], all_found[cell]
        within, reach = reaches[cell, 0], reaches[cell, 0] + reaches[cell, 1]
        found[:] = 0.0
        middles, radii = spheres(all_points[cell : cell + 1], starts)
        middle, radius = middles[0], radii[0]
        for one in range(starts.size - 1):
            for other in range(one, starts.size - 1):
                bound = radius[one] + radius[other] + reach
                if squared(apart(middle[one], middle[other])) >= bound * bound:
                    continue
                for p in range(starts[one], starts[one + 1]):
                    for q in range(starts[other], starts[other + 1]):
                        if dot(normals[p], normals[q]) >= 0.0:
                            continue
                        away = apart(points[p], points[q])
                        square = squared(away)
                        if square >= reach * reach:
                            continue
                        height = min(abs(dot(away, normals[p])), abs(dot(away, normals[q])))
                        if height < within + BEND * (square - height * height):
                            found[p] = found[q] = 1.0
        cell = next_part(work)
    return 1
