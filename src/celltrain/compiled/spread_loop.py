"""A compiled loop that spreads values at points over a grid (see `flow.spreading`)."""

import numpy as np

from celltrain.compiled.call_frame import numbers, result, result_sizes, sizes
from celltrain.compiled.grid_kernel import add, cover, first_covered, slab_depth
from celltrain.compiled.loops import SPREAD
from celltrain.compiled.shared_work import frame_of, next_part, task


@task(SPREAD.name)
def _spread(work: int) -> int:
    """Fields [field, x, y, z] of values [point, field]. Parts: slabs of grid points along z.

    Further arguments: places [point, axis] and the kernel's terms. Room on both sides of a slab
    takes what points give beyond it; it is dropped, as it is computed again for the slab there.
    """
    frame = frame_of(work)
    points, fields = sizes(frame, 0)
    term_count, _, width = sizes(frame, 2)
    values = numbers(frame, 0).reshape((points, fields))
    places = numbers(frame, 1).reshape((points, 3))
    terms = numbers(frame, 2).reshape((term_count, 3, width))
    _, along_x, along_y, along_z = result_sizes(frame)
    found = result(frame).reshape((fields, along_x, along_y, along_z))

    depth, beside, covered = slab_depth(along_z), width - 1, width * fields
    room = np.empty((along_x, along_y, (depth + 2 * beside) * fields))
    weights, offsets = np.empty((3, width)), np.empty((3, width))
    row = np.empty(covered)
    begin = depth * next_part(work)
    while begin < along_z:
        end = min(begin + depth, along_z)
        room[:] = 0.0
        for point in range(points):
            lowest = first_covered(places[point, 2], along_z, width) - begin
            if lowest >= end - begin:
                lowest -= along_z
            if lowest <= -width:
                continue
            cover(places[point], terms, offsets, weights)
            for i in range(width):
                for field in range(fields):
                    row[i * fields + field] = weights[2, i] * values[point, field]
            # Also as the point's images before it: the grid is periodic.
            while lowest > -width:
                start = (lowest + beside) * fields
                x = first_covered(places[point, 0], along_x, width)
                for i in range(width):
                    if weights[0, i] != 0.0:
                        y = first_covered(places[point, 1], along_y, width)
                        for j in range(width):
                            into = room[x, y, start : start + covered]
                            add(into, row, weights[0, i] * weights[1, j])
                            y = y + 1 if y + 1 < along_y else 0
                    x = x + 1 if x + 1 < along_x else 0
                lowest -= along_z
        for field in range(fields):
            for x in range(along_x):
                for y in range(along_y):
                    given = room[x, y]
                    for z in range(begin, end):
                        found[field, x, y, z] = given[(z - begin + beside) * fields + field]
        begin = depth * next_part(work)
    return 1
