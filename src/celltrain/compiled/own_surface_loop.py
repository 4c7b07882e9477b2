"""A compiled loop for the velocity on cells by the near kernel of their own force.

Harmonics at the nodes about the targets (see `polar_lanes`), and the sums over them, in one: the
sum of the formula in `flow.own_surface`.
"""

import numpy as np

from celltrain.compiled.call_frame import (
    numbers,
    result,
    sizes,
)
from celltrain.compiled.loops import OWN_FORCES
from celltrain.compiled.polar_lanes import (
    FORCE_CHANNELS,
    FORCE_TARGETS,
    LANES,
    arrange_tables,
    pair_weights,
    rotate,
    shift,
    sum_forces,
)
from celltrain.compiled.shared_work import frame_of, next_part, task


@task(OWN_FORCES.name)
def _own_forces(work: int) -> int:
    """Parts: so many targets of one after the other longitude and cell, on all rings."""
    frame = frame_of(work)
    cells, rings, longitudes, _ = sizes(frame, 0)
    size = sizes(frame, 1)[2]
    orders, radial, degree = sizes(frame, 4)
    azimuths = sizes(frame, 5)[1]
    targets = numbers(frame, 0).reshape((cells, rings, longitudes, 3))
    coefficients = numbers(frame, 1).reshape((cells, FORCE_CHANNELS, size))
    rotations = numbers(frame, 3).reshape((rings, size, size))
    tables = numbers(frame, 4).reshape((orders, radial, degree))
    around = numbers(frame, 5).reshape((orders, azimuths))
    xi = numbers(frame, 7)[0]
    found = result(frame).reshape((cells, rings, longitudes, 3))

    # Filled up with zeros: orders and degrees to a multiple of four, angles to one of two.
    filled, half = -(-degree // 4) * 4, (azimuths + 1) // 2
    latitude = np.zeros((radial + 1, filled, filled))
    longitude = np.zeros((azimuths + 1, 2, filled))
    turns = np.empty((longitudes, 2, degree))
    weights = np.zeros((radial, half + 1, 2))
    arrange_tables(tables, around, numbers(frame, 2), latitude, longitude, turns)
    pair_weights(numbers(frame, 6).reshape((radial, azimuths)), weights)

    shifted = np.empty((size, LANES))
    rotated = np.zeros((2, filled, filled, LANES))
    by_order = np.empty((2, 2, filled, LANES))
    parts = np.empty((2, 2, LANES))
    points, sums = np.empty((3, FORCE_TARGETS)), np.empty((3, FORCE_TARGETS))
    count = cells * longitudes
    first = FORCE_TARGETS * next_part(work)
    while first < count:
        shift(coefficients, turns, first, degree, shifted)
        for ring in range(rings):
            rotate(rotations[ring], shifted, degree, rotated)
            for lane in range(FORCE_TARGETS):
                cell, place = divmod(min(first + lane, count - 1), longitudes)
                for i in range(3):
                    points[i, lane] = targets[cell, ring, place, i]
            sum_forces(rotated, latitude, longitude, weights, points, xi, by_order, parts, sums)
            for lane in range(min(FORCE_TARGETS, count - first)):
                cell, place = divmod(first + lane, longitudes)
                for i in range(3):
                    found[cell, ring, place, i] = sums[i, lane]
        first = FORCE_TARGETS * next_part(work)
    return 1
