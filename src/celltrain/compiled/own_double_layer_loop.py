"""A compiled loop for the matrices of the double layer of cells on themselves.

Kernels at the nodes about the targets, and their sums with all harmonics (see `polar_lanes`): what
the formula in `flow.own_surface` gives.
"""

import math
from typing import Any

import numpy as np

from celltrain.compiled.call_frame import (
    numbers,
    result,
    sizes,
)
from celltrain.compiled.kernels import (
    cross,
    dot,
    free_stresslet,
    squared,
    stresslet_matrix,
    stresslet_scalars,
)
from celltrain.compiled.loops import OWN_DOUBLE_LAYER
from celltrain.compiled.pairs import near_parts
from celltrain.compiled.polar_lanes import (
    LANES,
    add_moments,
    arrange_tables,
    pair_weights,
    parts_at_azimuths,
    rotate,
    rotate_back,
    shift,
    shift_back,
    sums_over_azimuths,
    sums_over_degrees,
)
from celltrain.compiled.shared_work import frame_of, next_part, task
from celltrain.harmonics import UNIT_DISPLACEMENT
from celltrain.parts import FAST, part

# Components of the shape, targets at a time, and components of a symmetric matrix.
_CHANNELS, _COMPONENTS = 3, 6
_TARGETS = LANES // _CHANNELS


@part(fastmath=FAST, inline="always")
def _vector(parts: Any, start: int, even: float, odd: float, i: int) -> Any:
    """A vector at target i from its even and its odd part, which begin at `start`."""
    return (
        even * parts[start + i] + odd * parts[start + LANES + i],
        even * parts[start + _TARGETS + i] + odd * parts[start + LANES + _TARGETS + i],
        even * parts[start + 2 * _TARGETS + i] + odd * parts[start + LANES + 2 * _TARGETS + i],
    )


@part(fastmath=FAST)
def _kernels(parts: Any, sign: float, area: float, points: Any, i: int, xi: float) -> Any:
    """The near kernel at one node, times its area, and what it lacks of that in free space."""
    y = _vector(parts, 0, 1.0, sign, i)
    down = _vector(parts, 2 * LANES, 1.0, sign, i)
    # The slope along the azimuth of what is even is odd.
    around = _vector(parts, 4 * LANES, sign, 1.0, i)
    slopes = cross(down, around)
    normal = (area * slopes[0], area * slopes[1], area * slopes[2])
    d = (points[i] - y[0], points[_TARGETS + i] - y[1], points[2 * _TARGETS + i] - y[2])
    square, through = squared(d), dot(d, normal)
    screened, gauss, inverse_square = near_parts(square, xi)
    linear, cubic = stresslet_scalars(screened, gauss, inverse_square, xi)
    near = stresslet_matrix(linear, cubic * through, through, d, normal)
    # Signs of T(y - x) = -T(x - y).
    free = -free_stresslet(square, math.sqrt(inverse_square)) * through
    along = (free * d[0], free * d[1], free * d[2])
    lacking = (
        along[0] * d[0] - near[0],
        along[0] * d[1] - near[1],
        along[0] * d[2] - near[2],
        along[1] * d[1] - near[3],
        along[1] * d[2] - near[4],
        along[2] * d[2] - near[5],
    )
    return near, lacking


@part(fastmath=FAST)
def _keep(here: Any, there: Any, i: int, kept: Any) -> None:
    """Even parts of the components, then odd ones."""
    odd = 2 * LANES + i
    kept[i], kept[odd] = here[0] + there[0], here[0] - there[0]
    kept[_TARGETS + i], kept[_TARGETS + odd] = here[1] + there[1], here[1] - there[1]
    kept[2 * _TARGETS + i], kept[2 * _TARGETS + odd] = here[2] + there[2], here[2] - there[2]
    kept[3 * _TARGETS + i], kept[3 * _TARGETS + odd] = here[3] + there[3], here[3] - there[3]
    kept[4 * _TARGETS + i], kept[4 * _TARGETS + odd] = here[4] + there[4], here[4] - there[4]
    kept[5 * _TARGETS + i], kept[5 * _TARGETS + odd] = here[5] + there[5], here[5] - there[5]


@part(fastmath=FAST)
def _pair(parts: Any, areas: Any, points: Any, xi: float, near: Any, lacking: Any) -> None:
    """Even and odd parts, [side, lane], of the kernels at a node and its opposite.

    Arrays are flat, so that LLVM sees that they do not overlap. **Arguments:** `parts`: of places,
    slopes along the polar angle and along the azimuth, [quantity, side, lane].
    """
    one, other = areas[0], areas[1]
    for i in range(_TARGETS):
        here, more_here = _kernels(parts, 1.0, one, points, i, xi)
        there, more_there = _kernels(parts, -1.0, other, points, i, xi)
        _keep(here, there, i, near)
        _keep(more_here, more_there, i, lacking)


@part()
def _take_from_target(near: Any, lacking: Any) -> None:
    """Subtract the rule's error for a constant, -1/2 in free space, at the target itself."""
    # The coefficient of the constant 1 is that of a displacement by one.
    degree, mean = near.shape[1], UNIT_DISPLACEMENT
    for component in range(_COMPONENTS):
        exact = -0.5 if component in (0, 3, 5) else 0.0
        for i in range(component * _TARGETS, (component + 1) * _TARGETS):
            error = exact - mean * (near[0, 0, 0, i] + lacking[0, 0, 0, i])
            for n in range(degree):
                near[0, 0, n, i] += error * math.sqrt((2 * n + 1) / (4.0 * math.pi))


@part()
def _areas(given: Any, inverse_sine: Any, areas: Any) -> None:
    """Weights of opposite nodes times what the tangents lack, over 8 pi."""
    pair_weights(given, areas)
    for r in range(areas.shape[0]):
        for a in range(areas.shape[1]):
            for side in range(2):
                areas[r, a, side] *= inverse_sine[r] / (8.0 * math.pi)


@task(OWN_DOUBLE_LAYER.name)
def _own_double_layer(work: int) -> int:
    """Parts: so many targets of one after the other longitude and cell, on all rings."""
    frame = frame_of(work)
    cells, rings, longitudes, _ = sizes(frame, 0)
    size = sizes(frame, 1)[2]
    orders, radial, degree = sizes(frame, 4)
    azimuths = sizes(frame, 6)[1]
    targets = numbers(frame, 0).reshape((cells, rings, longitudes, 3))
    shapes = numbers(frame, 1).reshape((cells, _CHANNELS, size))
    rotations = numbers(frame, 3).reshape((rings, size, size))
    low = int(numbers(frame, 10)[1])
    xi = numbers(frame, 10)[0]
    found = result(frame).reshape((cells, rings, longitudes, _COMPONENTS, size + low * low))

    # Filled up with zeros: orders and degrees, and pairs of azimuths, to a multiple of four.
    filled, half = -(-degree // 4) * 4, -(-((azimuths + 1) // 2) // 4) * 4
    latitude = np.zeros((2, radial + 1, filled, filled))
    longitude = np.zeros((2, max(azimuths, half), 2, filled))
    turns = np.empty((longitudes, 2, degree))
    areas = np.zeros((radial, half, 2))
    for slope in range(2):
        arrange_tables(
            numbers(frame, 4 + slope).reshape((orders, radial, degree)),
            numbers(frame, 6 + slope).reshape((orders, azimuths)),
            numbers(frame, 2),
            latitude[slope],
            longitude[slope],
            turns,
        )
    _areas(numbers(frame, 8).reshape((radial, azimuths)), numbers(frame, 9), areas)

    shifted = np.empty((size, LANES))
    rotated = np.zeros((2, filled, filled, LANES))
    by_order = np.empty((2, 2, 2, filled, LANES))
    flat_parts = np.empty((2, 6 * LANES))
    parts = flat_parts.reshape((2, 3, 2, LANES))
    flat_near, flat_lacking = np.zeros((half, 4 * LANES)), np.zeros((half, 4 * LANES))
    near = flat_near.reshape((half, 2, 2 * LANES))
    lacking = flat_lacking.reshape((half, 2, 2 * LANES))
    near_by_order = np.zeros((2, 2, degree, 2 * LANES))
    lacking_by_order = np.zeros((2, 2, low, 2 * LANES))
    near_moments = np.empty((2, degree, degree, 2 * LANES))
    lacking_moments = np.empty((2, low, low, 2 * LANES))
    back = np.empty((size, 2 * LANES))
    points = np.empty(LANES)
    count = cells * longitudes
    first = _TARGETS * next_part(work)
    while first < count:
        shift(shapes, turns, first, degree, shifted)
        for ring in range(rings):
            rotate(rotations[ring], shifted, degree, rotated)
            for lane in range(_TARGETS):
                cell, place = divmod(min(first + lane, count - 1), longitudes)
                for i in range(3):
                    points[i * _TARGETS + lane] = targets[cell, ring, place, i]
            near_moments[:] = 0.0
            lacking_moments[:] = 0.0
            for r in range(radial):
                if r % 2 == 0:
                    for slope in range(2):
                        sums_over_degrees(rotated, latitude[slope, r : r + 2], by_order[slope])
                for a in range(0, half, 2):
                    # Of places, and their slopes along the polar angle and along the azimuth.
                    for quantity in range(3):
                        rows = by_order[quantity % 2, r % 2]
                        at = longitude[quantity // 2, a : a + 2]
                        parts_at_azimuths(rows, at, parts[0, quantity], parts[1, quantity])
                    for b in range(a, min(a + 2, (azimuths + 1) // 2)):
                        at_pair = flat_parts[b - a], areas[r, b]
                        _pair(at_pair[0], at_pair[1], points, xi, flat_near[b], flat_lacking[b])
                for kind in range(2):
                    given = near if kind == 0 else lacking
                    orders = near_by_order if kind == 0 else lacking_by_order
                    sums_over_azimuths(given, longitude[0], orders[r % 2])
                    if r % 2 == 1 or r == radial - 1:
                        begin = r - r % 2
                        moments = near_moments if kind == 0 else lacking_moments
                        add_moments(orders, latitude[0, begin : begin + 2], moments)
            _take_from_target(near_moments, lacking_moments)
            for start in (0, size):
                rotate_back(rotations[ring], lacking_moments if start else near_moments, back)
                for lane in range(min(_TARGETS, count - first)):
                    cell, place = divmod(first + lane, longitudes)
                    matrix, end = found[cell, ring, place], low * low if start else size
                    shift_back(back[:end], turns[place], lane, start, matrix)
        first = _TARGETS * next_part(work)
    return 1
