"""A compiled loop for the velocity on cells by the near kernel of their own force.

Harmonics at the nodes about the targets, and the sums over them, in one: a few targets at a time,
each a lane of every vector, so that all intermediate numbers stay in the processor's cache. The sum
is that of the formula in `flow.own_surface`, with what is known of its tables: a rotation mixes
neither degrees nor cosines with sines, and nodes come in pairs of opposite azimuth.
"""

import math
from typing import Any

import numpy as np
from numba import njit

from celltrain.compiled.call_frame import (
    FLOATS,
    describe,
    fits,
    handler,
    is_question,
    numbers,
    refuse,
    result,
    sizes,
)
from celltrain.compiled.kernels import squared, stokeslet, stokeslet_scalars
from celltrain.compiled.near_loops import FAST, near_parts

#: Name under which XLA finds the loop.
OWN_FORCES = "celltrain_own_forces"

_ARGUMENTS = (FLOATS,) * 8
# Targets at a time, components of shape and force, and numbers side by side.
_TARGETS, _CHANNELS = 16, 6
_LANES = _TARGETS * _CHANNELS


@njit(fastmath=FAST, error_model="numpy")
def _shift(coefficients: Any, turns: Any, first: int, degree: int, shifted: Any) -> None:
    """Coefficients [cell, channel, k] with each target's longitude brought to 0, [k, lane].

    **Arguments:** `turns`: [longitude, cosine or sine, order]; `first`: number of the first target.
    """
    longitudes = turns.shape[0]
    last = coefficients.shape[0] * longitudes - 1
    for lane in range(_TARGETS):
        cell, place = divmod(min(first + lane, last), longitudes)
        for m in range(degree):
            cosine, sine = turns[place, 0, m], turns[place, 1, m]
            for n in range(m, degree):
                even, odd = n * n + n + m, n * n + n - m
                for channel in range(_CHANNELS):
                    one, other = (
                        coefficients[cell, channel, even],
                        coefficients[cell, channel, odd],
                    )
                    shifted[even, channel * _TARGETS + lane] = cosine * one + sine * other
                    if m > 0:
                        shifted[odd, channel * _TARGETS + lane] = cosine * other - sine * one


@njit(fastmath=FAST, error_model="numpy")
def _rotate(rotation: Any, shifted: Any, degree: int, rotated: Any) -> None:
    """Coefficients [k, lane] in the frame of a ring, [cosine or sine, order, n, lane]."""
    for n in range(degree):
        middle = n * n + n
        for m in range(n + 1):
            for side in range(2 if m > 0 else 1):
                row = rotation[middle - m if side else middle + m]
                sums = rotated[side, m, n]
                sums[:] = 0.0
                for k in range(side, n + 1):
                    column = middle - k if side else middle + k
                    amount = row[column]
                    for i in range(_LANES):
                        sums[i] += amount * shifted[column, i]


@njit(fastmath=FAST, error_model="numpy")
def _by_order(rotated: Any, latitude: Any, sums: Any) -> None:
    """Sums over n at two polar angles, [angle, side, order, lane]; latitude: [angle, order, n]."""
    degrees = rotated.shape[2]
    sums[:] = 0.0
    for side in range(2):
        for m in range(side, degrees):
            rows, one, other = rotated[side, m], sums[0, side, m], sums[1, side, m]
            for n in range(m // 4 * 4, degrees, 4):
                a, b = latitude[0, m, n], latitude[0, m, n + 1]
                c, d = latitude[0, m, n + 2], latitude[0, m, n + 3]
                e, f = latitude[1, m, n], latitude[1, m, n + 1]
                g, h = latitude[1, m, n + 2], latitude[1, m, n + 3]
                for i in range(_LANES):
                    p, q, r, s = rows[n, i], rows[n + 1, i], rows[n + 2, i], rows[n + 3, i]
                    one[i] += a * p + b * q + c * r + d * s
                    other[i] += e * p + f * q + g * r + h * s


@njit(fastmath=FAST, error_model="numpy")
def _parts(by_order: Any, longitude: Any, parts: Any) -> None:
    """What is even and odd in the azimuth, at two azimuths, [azimuth, side, lane].

    **Arguments:** `by_order`: [side, order, lane]; `longitude`: [azimuth, side, order].
    """
    parts[:] = 0.0
    for side in range(2):
        rows, one, other = by_order[side], parts[0, side], parts[1, side]
        for m in range(0, rows.shape[0], 4):
            a, b = longitude[0, side, m], longitude[0, side, m + 1]
            c, d = longitude[0, side, m + 2], longitude[0, side, m + 3]
            e, f = longitude[1, side, m], longitude[1, side, m + 1]
            g, h = longitude[1, side, m + 2], longitude[1, side, m + 3]
            for i in range(_LANES):
                p, q, r, s = rows[m, i], rows[m + 1, i], rows[m + 2, i], rows[m + 3, i]
                one[i] += a * p + b * q + c * r + d * s
                other[i] += e * p + f * q + g * r + h * s


@njit(fastmath=FAST, inline="always", error_model="numpy")
def _node(values: Any, sign: float, points: Any, i: int, xi: float) -> Any:
    """Velocity at target i by one node, of which `values` are the parts, [side, lane]."""
    d = (
        points[0, i] - (values[0, i] + sign * values[1, i]),
        points[1, i] - (values[0, _TARGETS + i] + sign * values[1, _TARGETS + i]),
        points[2, i] - (values[0, 2 * _TARGETS + i] + sign * values[1, 2 * _TARGETS + i]),
    )
    force = (
        values[0, 3 * _TARGETS + i] + sign * values[1, 3 * _TARGETS + i],
        values[0, 4 * _TARGETS + i] + sign * values[1, 4 * _TARGETS + i],
        values[0, 5 * _TARGETS + i] + sign * values[1, 5 * _TARGETS + i],
    )
    near = near_parts(squared(d), xi)
    return stokeslet(stokeslet_scalars(near[0], near[1], near[2]), d, force)


@njit(fastmath=FAST, error_model="numpy")
def _add_nodes(parts: Any, weights: Any, points: Any, xi: float, sums: Any) -> None:
    """Add to the velocities what the nodes at two azimuths and their opposites give.

    **Arguments:** `weights`: [azimuth, side]; `points`, `sums`: [component, target].
    """
    one, other = parts[0], parts[1]
    p, q, r, s = weights[0, 0], weights[0, 1], weights[1, 0], weights[1, 1]
    for i in range(_TARGETS):
        a = _node(one, 1.0, points, i, xi)
        b = _node(one, -1.0, points, i, xi)
        c = _node(other, 1.0, points, i, xi)
        d = _node(other, -1.0, points, i, xi)
        sums[0, i] += p * a[0] + q * b[0] + r * c[0] + s * d[0]
        sums[1, i] += p * a[1] + q * b[1] + r * c[1] + s * d[1]
        sums[2, i] += p * a[2] + q * b[2] + r * c[2] + s * d[2]


@njit(error_model="numpy")
def _prepare(
    by_order: Any, around: Any, angles: Any, latitude: Any, longitude: Any, turns: Any
) -> None:
    """Arrange the tables, given by order from the lowest: what is left out of them stays zero.

    **Arguments:** `latitude`: [radial, order, n]; `longitude`: [azimuth, side, order]; `turns`:
    [longitude, side, order].
    """
    _, radial, degree = by_order.shape
    for m in range(degree):
        for r in range(radial):
            for n in range(m, degree):
                latitude[r, m, n] = by_order[degree - 1 + m, r, n]
        for a in range(around.shape[1]):
            longitude[a, 0, m] = around[degree - 1 + m, a]
            if m > 0:
                longitude[a, 1, m] = around[degree - 1 - m, a]
        for place in range(angles.size):
            turns[place, 0, m] = math.cos(m * angles[place])
            turns[place, 1, m] = math.sin(m * angles[place])


@njit(error_model="numpy")
def _pair_weights(given: Any, weights: Any) -> None:
    """Weights [radial, azimuth, side] of opposite nodes; one that is its own counts once."""
    radial, azimuths = given.shape
    for r in range(radial):
        for a in range((azimuths + 1) // 2):
            weights[r, a, 0] = given[r, a]
            if azimuths - 1 - a > a:
                weights[r, a, 1] = given[r, azimuths - 1 - a]


@njit(error_model="numpy")
def _own_forces(frame: int) -> None:
    cells, rings, longitudes, _ = sizes(frame, 0)
    size = sizes(frame, 1)[2]
    orders, radial, degree = sizes(frame, 4)
    azimuths = sizes(frame, 5)[1]
    targets = numbers(frame, 0).reshape((cells, rings, longitudes, 3))
    coefficients = numbers(frame, 1).reshape((cells, _CHANNELS, size))
    rotations = numbers(frame, 3).reshape((rings, size, size))
    by_order = numbers(frame, 4).reshape((orders, radial, degree))
    around = numbers(frame, 5).reshape((orders, azimuths))
    xi = numbers(frame, 7)[0]
    found = result(frame).reshape((cells, rings, longitudes, 3))

    # Filled up with zeros: orders and degrees to a multiple of four, angles to one of two.
    filled, half = -(-degree // 4) * 4, (azimuths + 1) // 2
    latitude = np.zeros((radial + 1, filled, filled))
    longitude = np.zeros((azimuths + 1, 2, filled))
    turns = np.empty((longitudes, 2, degree))
    weights = np.zeros((radial, half + 1, 2))
    _prepare(by_order, around, numbers(frame, 2), latitude, longitude, turns)
    _pair_weights(numbers(frame, 6).reshape((radial, azimuths)), weights)

    shifted = np.empty((size, _LANES))
    rotated = np.zeros((2, filled, filled, _LANES))
    sums_by_order = np.empty((2, 2, filled, _LANES))
    parts = np.empty((2, 2, _LANES))
    points, sums = np.empty((3, _TARGETS)), np.empty((3, _TARGETS))
    count = cells * longitudes
    for first in range(0, count, _TARGETS):
        _shift(coefficients, turns, first, degree, shifted)
        for ring in range(rings):
            _rotate(rotations[ring], shifted, degree, rotated)
            for lane in range(_TARGETS):
                cell, place = divmod(min(first + lane, count - 1), longitudes)
                for i in range(3):
                    points[i, lane] = targets[cell, ring, place, i]
                    sums[i, lane] = 0.0
            for r in range(radial):
                if r % 2 == 0:
                    _by_order(rotated, latitude[r : r + 2], sums_by_order)
                for a in range(0, half, 2):
                    _parts(sums_by_order[r % 2], longitude[a : a + 2], parts)
                    _add_nodes(parts, weights[r, a : a + 2], points, xi, sums)
            for lane in range(min(_TARGETS, count - first)):
                cell, place = divmod(first + lane, longitudes)
                for i in range(3):
                    found[cell, ring, place, i] = sums[i, lane]


@handler(OWN_FORCES)
def _own_forces_handler(frame: int) -> int:
    if is_question(frame):
        return describe(frame)
    if not fits(frame, _ARGUMENTS):
        return refuse(frame)
    _own_forces(frame)
    return 0
