"""A compiled loop that spreads values at points over a grid (see `flow.spreading`)."""

import numpy as np

from celltrain.compiled.call_frame import integers, numbers, result, result_sizes, sizes
from celltrain.compiled.loops import SPREAD
from celltrain.compiled.shared_work import frame_of, next_part, task
from celltrain.compiled.slabs import slab_depth
from celltrain.parts import FAST, part


@part(fastmath=FAST)
def _add(into: np.ndarray, row: np.ndarray, amount: float) -> None:
    for i in range(row.size):
        into[i] += amount * row[i]


@task(SPREAD.name)
def _spread(work: int) -> int:
    """Fields [field, x, y, z] of values [point, field]. Parts: slabs of grid points along z.

    Further arguments: first grid points [axis, point] and weights [axis, point, covered]. A slab
    has room on both sides for what points near its ends give to others, which these find again.
    """
    frame = frame_of(work)
    points, fields = sizes(frame, 0)
    width = sizes(frame, 2)[2]
    values = numbers(frame, 0).reshape((points, fields))
    first = integers(frame, 1).reshape((3, points))
    weights = numbers(frame, 2).reshape((3, points, width))
    _, along_x, along_y, along_z = result_sizes(frame)
    found = result(frame).reshape((fields, along_x, along_y, along_z))

    depth, beside, covered = slab_depth(along_z), width - 1, width * fields
    room = np.empty((along_x, along_y, (depth + 2 * beside) * fields))
    row = np.empty(covered)
    begin = depth * next_part(work)
    while begin < along_z:
        end = min(begin + depth, along_z)
        room[:] = 0.0
        for point in range(points):
            # Also as the point's image before the grid, which is periodic.
            for turn in range(2):
                lowest = first[2, point] - turn * along_z - begin
                if lowest <= -width or lowest >= end - begin:
                    continue
                for i in range(width):
                    for field in range(fields):
                        row[i * fields + field] = weights[2, point, i] * values[point, field]
                start = (lowest + beside) * fields
                x = first[0, point]
                for i in range(width):
                    by_x = weights[0, point, i]
                    if by_x != 0.0:
                        y = first[1, point]
                        for j in range(width):
                            into = room[x, y, start : start + covered]
                            _add(into, row, by_x * weights[1, point, j])
                            y = y + 1 if y + 1 < along_y else 0
                    x = x + 1 if x + 1 < along_x else 0
        for field in range(fields):
            for x in range(along_x):
                for y in range(along_y):
                    given = room[x, y]
                    for z in range(begin, end):
                        found[field, x, y, z] = given[(z - begin + beside) * fields + field]
        begin = depth * next_part(work)
    return 1
