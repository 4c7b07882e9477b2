"""A compiled loop that interpolates fields on a grid at points (see `flow.spreading`)."""

import numpy as np

from celltrain.compiled.call_frame import integers, numbers, result, sizes
from celltrain.compiled.loops import INTERPOLATE
from celltrain.compiled.shared_work import frame_of, next_part, task
from celltrain.compiled.slabs import slab_depth
from celltrain.parts import FAST, part


@part(fastmath=FAST)
def _add(row: np.ndarray, given: np.ndarray, amount: float) -> None:
    for i in range(row.size):
        row[i] += amount * given[i]


@task(INTERPOLATE.name)
def _interpolate(work: int) -> int:
    """Values [point, field] of fields [field, x, y, z]. Parts: slabs of grid points along z.

    Further arguments: first grid points [axis, point] and weights [axis, point, covered]. Fields
    of a slab, and of what points in it reach beyond, are brought together at each grid point.
    """
    frame = frame_of(work)
    fields, along_x, along_y, along_z = sizes(frame, 0)
    _, points, width = sizes(frame, 2)
    grid = numbers(frame, 0).reshape((fields, along_x, along_y, along_z))
    first = integers(frame, 1).reshape((3, points))
    weights = numbers(frame, 2).reshape((3, points, width))
    found = result(frame).reshape((points, fields))

    depth, covered = slab_depth(along_z), width * fields
    room = np.empty((along_x, along_y, (depth + width - 1) * fields))
    row = np.empty(covered)
    begin = depth * next_part(work)
    while begin < along_z:
        end = min(begin + depth, along_z)
        for field in range(fields):
            for x in range(along_x):
                for y in range(along_y):
                    given, into = grid[field, x, y], room[x, y]
                    for i in range(end - begin + width - 1):
                        z = begin + i
                        into[i * fields + field] = given[z if z < along_z else z - along_z]
        for point in range(points):
            z = first[2, point]
            if z < begin or z >= end:
                continue
            start = (z - begin) * fields
            row[:] = 0.0
            x = first[0, point]
            for i in range(width):
                by_x = weights[0, point, i]
                if by_x != 0.0:
                    y = first[1, point]
                    for j in range(width):
                        given = room[x, y, start : start + covered]
                        _add(row, given, by_x * weights[1, point, j])
                        y = y + 1 if y + 1 < along_y else 0
                x = x + 1 if x + 1 < along_x else 0
            for field in range(fields):
                total = 0.0
                for i in range(width):
                    total += weights[2, point, i] * row[i * fields + field]
                found[point, field] = total
        begin = depth * next_part(work)
    return 1
