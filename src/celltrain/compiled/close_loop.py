"""A compiled loop for the velocity close to cells by the near kernel of their force.

Every pair of a target and a cell has a pole of its own, to which shape and force are turned by two
quarter turns (see `harmonics.rotation`) before the sums over the nodes (see `polar_lanes`): what
the formulas in `flow.close` and `flow.polar` give.
"""

import math
from typing import Any

import numpy as np

from celltrain.compiled.call_frame import (
    integers,
    numbers,
    result,
    sizes,
)
from celltrain.compiled.loops import CLOSE_FORCES
from celltrain.compiled.polar_lanes import (
    FORCE_CHANNELS,
    FORCE_TARGETS,
    LANES,
    arrange_tables,
    pair_weights,
    sum_forces,
)
from celltrain.compiled.shared_work import frame_of, next_part, task
from celltrain.parts import FAST, part


@part()
def _turns(angles: Any, cosine: Any, sine: Any) -> None:
    """cos(m a) and sin(m a) of each target's angle, [order, lane]."""
    for m in range(cosine.shape[0]):
        for target in range(FORCE_TARGETS):
            even, odd = math.cos(m * angles[target]), math.sin(m * angles[target])
            for channel in range(FORCE_CHANNELS):
                cosine[m, channel * FORCE_TARGETS + target] = even
                sine[m, channel * FORCE_TARGETS + target] = odd


@part(fastmath=FAST)
def _turn(values: Any, cosine: Any, sine: Any) -> None:
    """Coefficients [k, lane] with the longitude of each target brought to 0, in place."""
    degree = cosine.shape[0]
    for m in range(1, degree):
        even, odd = cosine[m], sine[m]
        for n in range(m, degree):
            one, other = values[n * n + n + m], values[n * n + n - m]
            for i in range(LANES):
                a, b = one[i], other[i]
                one[i] = even[i] * a + odd[i] * b
                other[i] = even[i] * b - odd[i] * a


@part(fastmath=FAST)
def _rotated_row(matrix: Any, row: int, n: int, given: Any, sums: Any) -> None:
    """One row of a rotation, which does not mix degrees, times coefficients [k, lane]."""
    sums[:] = 0.0
    for column in range(n * n, (n + 1) * (n + 1)):
        amount = matrix[row, column]
        for i in range(LANES):
            sums[i] += amount * given[column, i]


@part()
def _to_pole(quarters: Any, turns: Any, given: Any, rotated: Any) -> None:
    """Coefficients [k, lane] seen from each target's pole, [cosine or sine, order, n, lane].

    **Arguments:** `quarters`: the quarter turn and its transpose; `turns`: those of longitude and
    colatitude, [angle, cosine or sine, order, lane]; `given`: coefficients and room for what lies
    between the two, [2, k, lane], overwritten.
    """
    for angle in range(2):
        _turn(given[angle], turns[angle, 0], turns[angle, 1])
        for n in range(turns.shape[2]):
            for m in range(-n, n + 1):
                row = n * n + n + m
                into = rotated[1 if m < 0 else 0, abs(m), n] if angle == 1 else given[1, row]
                _rotated_row(quarters[angle], row, n, given[angle], into)


@task(CLOSE_FORCES.name)
def _close_forces(work: int) -> int:
    """Parts: so many pairs of one level of distance."""
    frame = frame_of(work)
    pairs, _ = sizes(frame, 0)
    cells, _, size = sizes(frame, 3)
    levels, orders, radial, degree = sizes(frame, 8)
    azimuths = sizes(frame, 9)[1]
    points = numbers(frame, 0).reshape((pairs, 3))
    poles = numbers(frame, 1).reshape((pairs, 2))
    cell_of, pair_at, bounds = integers(frame, 2), integers(frame, 4), integers(frame, 5)
    coefficients = numbers(frame, 3).reshape((cells, FORCE_CHANNELS, size))
    quarters = np.empty((2, size, size))
    quarter = numbers(frame, 6).reshape((size, size))
    for row in range(size):
        for column in range(size):
            quarters[0, row, column] = quarters[1, column, row] = quarter[row, column]
    around = numbers(frame, 9).reshape((orders, azimuths))
    by_level = numbers(frame, 8).reshape((levels, orders, radial, degree))
    given_weights = numbers(frame, 7).reshape((levels, radial))
    xi = numbers(frame, 10)[0]
    found = result(frame).reshape((pairs, 3))

    # Filled up with zeros: orders and degrees to a multiple of four, angles to one of two.
    filled, half = -(-degree // 4) * 4, (azimuths + 1) // 2
    latitude = np.zeros((radial + 1, filled, filled))
    longitude = np.zeros((azimuths + 1, 2, filled))
    weights = np.zeros((radial, half + 1, 2))
    node_weights = np.empty((radial, azimuths))
    no_angles, no_turns = np.empty(0), np.empty((0, 2, degree))

    angles = np.empty((2, FORCE_TARGETS))
    turns = np.empty((2, 2, degree, LANES))
    shifted = np.empty((2, size, LANES))
    rotated = np.zeros((2, filled, filled, LANES))
    by_order = np.empty((2, 2, filled, LANES))
    parts = np.empty((2, 2, LANES))
    targets, sums = np.empty((3, FORCE_TARGETS)), np.empty((3, FORCE_TARGETS))
    level, before, arranged = 0, 0, -1
    number = next_part(work)
    while True:
        # Numbers of parts only grow.
        while level < levels:
            here = -(-(bounds[level + 1] - bounds[level]) // FORCE_TARGETS)
            if number < before + here:
                break
            before, level = before + here, level + 1
        if level == levels:
            break
        if arranged != level:
            arrange_tables(by_level[level], around, no_angles, latitude, longitude, no_turns)
            for r in range(radial):
                for a in range(azimuths):
                    node_weights[r, a] = given_weights[level, r]
            pair_weights(node_weights, weights)
            arranged = level
        first = bounds[level] + FORCE_TARGETS * (number - before)
        for lane in range(FORCE_TARGETS):
            # What is beyond the last pair repeats it.
            pair = pair_at[min(first + lane, bounds[level + 1] - 1)]
            angles[0, lane], angles[1, lane] = poles[pair, 1], poles[pair, 0]
            for i in range(3):
                targets[i, lane] = points[pair, i]
            for channel in range(FORCE_CHANNELS):
                into = channel * FORCE_TARGETS + lane
                for k in range(size):
                    shifted[0, k, into] = coefficients[cell_of[pair], channel, k]
        for angle in range(2):
            _turns(angles[angle], turns[angle, 0], turns[angle, 1])
        _to_pole(quarters, turns, shifted, rotated)
        sum_forces(rotated, latitude, longitude, weights, targets, xi, by_order, parts, sums)
        for lane in range(min(FORCE_TARGETS, bounds[level + 1] - first)):
            pair = pair_at[first + lane]
            for i in range(3):
                found[pair, i] = sums[i, lane]
        number = next_part(work)
    return 1
