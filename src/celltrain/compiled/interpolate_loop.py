"""A compiled loop that interpolates fields on a grid at points (see `flow.spreading`)."""

import numpy as np

from celltrain.compiled.call_frame import numbers, result, sizes
from celltrain.compiled.grid_kernel import add, cover, first_covered, slab_depth
from celltrain.compiled.loops import INTERPOLATE
from celltrain.compiled.shared_work import frame_of, next_part, task


@task(INTERPOLATE.name)
def _interpolate(work: int) -> int:
    """Values [point, field] of fields [field, x, y, z]. Parts: slabs of grid points along z.

    Further arguments: places [point, axis] and the kernel's terms. Fields of a slab, and of what
    points in it reach beyond, are brought together at each grid point.
    """
    frame = frame_of(work)
    fields, along_x, along_y, along_z = sizes(frame, 0)
    points = sizes(frame, 1)[0]
    term_count, _, width = sizes(frame, 2)
    grid = numbers(frame, 0).reshape((fields, along_x, along_y, along_z))
    places = numbers(frame, 1).reshape((points, 3))
    terms = numbers(frame, 2).reshape((term_count, 3, width))
    found = result(frame).reshape((points, fields))

    depth, covered = slab_depth(along_z), width * fields
    room = np.empty((along_x, along_y, (depth + width - 1) * fields))
    weights, offsets = np.empty((3, width)), np.empty((3, width))
    row = np.empty(covered)
    begin = depth * next_part(work)
    while begin < along_z:
        end = min(begin + depth, along_z)
        for field in range(fields):
            for x in range(along_x):
                for y in range(along_y):
                    given, into = grid[field, x, y], room[x, y]
                    for i in range(end - begin + width - 1):
                        into[i * fields + field] = given[(begin + i) % along_z]
        for point in range(points):
            lowest = first_covered(places[point, 2], along_z, width)
            if lowest < begin or lowest >= end:
                continue
            cover(places[point], terms, offsets, weights)
            start = (lowest - begin) * fields
            row[:] = 0.0
            x = first_covered(places[point, 0], along_x, width)
            for i in range(width):
                if weights[0, i] != 0.0:
                    y = first_covered(places[point, 1], along_y, width)
                    for j in range(width):
                        given = room[x, y, start : start + covered]
                        add(row, given, weights[0, i] * weights[1, j])
                        y = y + 1 if y + 1 < along_y else 0
                x = x + 1 if x + 1 < along_x else 0
            for field in range(fields):
                total = 0.0
                for i in range(width):
                    total += weights[2, i] * row[i * fields + field]
                found[point, field] = total
        begin = depth * next_part(work)
    return 1
