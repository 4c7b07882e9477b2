"""Harmonics at the nodes about some targets at a time, in compiled loops.

Each target is a lane of every vector, so that what is computed for these targets stays in the
processor's cache. A rotation mixes neither degrees nor cosines with sines, and nodes come in pairs
of opposite azimuth: the tables are those of `harmonics.polar`, arranged for this.
"""

import math
from typing import Any

import numpy as np

from celltrain.compiled.kernels import squared, stokeslet, stokeslet_scalars
from celltrain.compiled.pairs import near_parts
from celltrain.parts import FAST, part

#: Numbers side by side: targets times components.
LANES = 96
#: Components of a shape and its force, and targets at a time of which these are wanted.
FORCE_CHANNELS = 6
FORCE_TARGETS = LANES // FORCE_CHANNELS


@part(fastmath=FAST)
def shift(
    coefficients: np.ndarray, turns: np.ndarray, first: int, degree: int, shifted: np.ndarray
) -> None:
    """Coefficients [cell, channel, k] with each target's longitude brought to 0, [k, lane].

    **Arguments:** `turns`: [longitude, cosine or sine, order]; `first`: number of the first target.
    """
    channels, longitudes = coefficients.shape[1], turns.shape[0]
    targets = LANES // channels
    last = coefficients.shape[0] * longitudes - 1
    for lane in range(targets):
        cell, place = divmod(min(first + lane, last), longitudes)
        for m in range(degree):
            cosine, sine = turns[place, 0, m], turns[place, 1, m]
            for n in range(m, degree):
                even, odd = n * n + n + m, n * n + n - m
                for channel in range(channels):
                    one, other = (
                        coefficients[cell, channel, even],
                        coefficients[cell, channel, odd],
                    )
                    shifted[even, channel * targets + lane] = cosine * one + sine * other
                    if m > 0:
                        shifted[odd, channel * targets + lane] = cosine * other - sine * one


@part(fastmath=FAST)
def rotate(rotation: np.ndarray, shifted: np.ndarray, degree: int, rotated: np.ndarray) -> None:
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
                    for i in range(LANES):
                        sums[i] += amount * shifted[column, i]


@part(fastmath=FAST)
def sums_over_degrees(rotated: np.ndarray, latitude: np.ndarray, sums: np.ndarray) -> None:
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
                for i in range(LANES):
                    p, q, r, s = rows[n, i], rows[n + 1, i], rows[n + 2, i], rows[n + 3, i]
                    one[i] += a * p + b * q + c * r + d * s
                    other[i] += e * p + f * q + g * r + h * s


@part(fastmath=FAST)
def parts_at_azimuths(
    by_order: np.ndarray, longitude: np.ndarray, first: np.ndarray, second: np.ndarray
) -> None:
    """What is even and odd in the azimuth, [side, lane], at a first and a second azimuth.

    **Arguments:** `by_order`: [side, order, lane]; `longitude`: [azimuth, side, order].
    """
    first[:] = 0.0
    second[:] = 0.0
    for side in range(2):
        rows, one, other = by_order[side], first[side], second[side]
        for m in range(0, rows.shape[0], 4):
            a, b = longitude[0, side, m], longitude[0, side, m + 1]
            c, d = longitude[0, side, m + 2], longitude[0, side, m + 3]
            e, f = longitude[1, side, m], longitude[1, side, m + 1]
            g, h = longitude[1, side, m + 2], longitude[1, side, m + 3]
            for i in range(LANES):
                p, q, r, s = rows[m, i], rows[m + 1, i], rows[m + 2, i], rows[m + 3, i]
                one[i] += a * p + b * q + c * r + d * s
                other[i] += e * p + f * q + g * r + h * s


@part()
def arrange_tables(
    by_order: np.ndarray,
    around: np.ndarray,
    angles: np.ndarray,
    latitude: np.ndarray,
    longitude: np.ndarray,
    turns: np.ndarray,
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


@part()
def pair_weights(given: np.ndarray, weights: np.ndarray) -> None:
    """Weights [radial, azimuth, side] of opposite nodes; one that is its own counts once."""
    radial, azimuths = given.shape
    for r in range(radial):
        for a in range((azimuths + 1) // 2):
            weights[r, a, 0] = given[r, a]
            if azimuths - 1 - a > a:
                weights[r, a, 1] = given[r, azimuths - 1 - a]


@part(fastmath=FAST)
def _node(values: Any, sign: float, points: Any, i: int, xi: float) -> Any:
    """Velocity at target i by one node, of which `values` are the parts, [side, lane]."""
    d = (
        points[0, i] - (values[0, i] + sign * values[1, i]),
        points[1, i] - (values[0, FORCE_TARGETS + i] + sign * values[1, FORCE_TARGETS + i]),
        points[2, i] - (values[0, 2 * FORCE_TARGETS + i] + sign * values[1, 2 * FORCE_TARGETS + i]),
    )
    force = (
        values[0, 3 * FORCE_TARGETS + i] + sign * values[1, 3 * FORCE_TARGETS + i],
        values[0, 4 * FORCE_TARGETS + i] + sign * values[1, 4 * FORCE_TARGETS + i],
        values[0, 5 * FORCE_TARGETS + i] + sign * values[1, 5 * FORCE_TARGETS + i],
    )
    near = near_parts(squared(d), xi)
    return stokeslet(stokeslet_scalars(near[0], near[1], near[2]), d, force)


@part(fastmath=FAST)
def _add_forces(parts: Any, weights: Any, points: Any, xi: float, sums: Any) -> None:
    """Add to the velocities what forces at two azimuths and their opposites give.

    **Arguments:** `parts`: of shape and force, [azimuth, side, lane]; `weights`: [azimuth, side];
    `points`, `sums`: [component, target].
    """
    one, other = parts[0], parts[1]
    p, q, r, s = weights[0, 0], weights[0, 1], weights[1, 0], weights[1, 1]
    for i in range(FORCE_TARGETS):
        a = _node(one, 1.0, points, i, xi)
        b = _node(one, -1.0, points, i, xi)
        c = _node(other, 1.0, points, i, xi)
        d = _node(other, -1.0, points, i, xi)
        sums[0, i] += p * a[0] + q * b[0] + r * c[0] + s * d[0]
        sums[1, i] += p * a[1] + q * b[1] + r * c[1] + s * d[1]
        sums[2, i] += p * a[2] + q * b[2] + r * c[2] + s * d[2]


@part()
def sum_forces(
    rotated: np.ndarray,
    latitude: np.ndarray,
    longitude: np.ndarray,
    weights: np.ndarray,
    points: np.ndarray,
    xi: float,
    by_order: np.ndarray,
    parts: np.ndarray,
    sums: np.ndarray,
) -> None:
    """Velocities at targets, [component, target], by forces at all nodes about them.

    **Arguments:** `rotated`: of shape and force, as seen from the targets; `weights`: [radial,
    azimuth, side], filled up by an azimuth; `by_order`, `parts`: room for what lies between.
    """
    sums[:] = 0.0
    for r in range(weights.shape[0]):
        if r % 2 == 0:
            sums_over_degrees(rotated, latitude[r : r + 2], by_order)
        for a in range(0, weights.shape[1] - 1, 2):
            parts_at_azimuths(by_order[r % 2], longitude[a : a + 2], parts[0], parts[1])
            _add_forces(parts, weights[r, a : a + 2], points, xi, sums)


@part(fastmath=FAST)
def sums_over_azimuths(parts: np.ndarray, longitude: np.ndarray, sums: np.ndarray) -> None:
    """Even and odd parts at pairs of nodes times the tables, [side, order, lane].

    **Arguments:** `parts`: [azimuth, side, lane], a multiple of four azimuths.
    """
    sums[:] = 0.0
    for side in range(2):
        for m in range(side, sums.shape[1]):
            into = sums[side, m]
            for n in range(0, parts.shape[0], 4):
                a, b = longitude[n, side, m], longitude[n + 1, side, m]
                c, d = longitude[n + 2, side, m], longitude[n + 3, side, m]
                p, q, r, s = (
                    parts[n, side],
                    parts[n + 1, side],
                    parts[n + 2, side],
                    parts[n + 3, side],
                )
                for i in range(2 * LANES):
                    into[i] += a * p[i] + b * q[i] + c * r[i] + d * s[i]


@part(fastmath=FAST)
def add_moments(by_order: np.ndarray, latitude: np.ndarray, moments: np.ndarray) -> None:
    """Add what two polar angles give to moments [side, order, n, lane].

    **Arguments:** `by_order`: [angle, side, order, lane]; `latitude`: [angle, order, n].
    """
    _, degrees, _, _ = moments.shape
    for side in range(2):
        for m in range(side, degrees):
            one, other = by_order[0, side, m], by_order[1, side, m]
            for n in range(m, degrees):
                a, b, into = latitude[0, m, n], latitude[1, m, n], moments[side, m, n]
                for i in range(2 * LANES):
                    into[i] += a * one[i] + b * other[i]


@part(fastmath=FAST)
def rotate_back(rotation: np.ndarray, moments: np.ndarray, rotated: np.ndarray) -> None:
    """Moments [side, order, n, lane] in the frame of a ring in that of the shape, [k, lane]."""
    degree = moments.shape[1]
    for n in range(degree):
        middle = n * n + n
        for m in range(n + 1):
            for side in range(2 if m > 0 else 1):
                column = middle - m if side else middle + m
                sums = rotated[column]
                sums[:] = 0.0
                for k in range(side, n + 1):
                    amount = rotation[middle - k if side else middle + k, column]
                    given = moments[side, k, n]
                    for i in range(2 * LANES):
                        sums[i] += amount * given[i]


@part(fastmath=FAST)
def shift_back(
    rotated: np.ndarray, turn: np.ndarray, lane: int, first: int, found: np.ndarray
) -> None:
    """Moments [k, lane] of one target as those of the shape as it lies, [component, first + k].

    **Arguments:** `turn`: [cosine or sine, order] of the target's longitude.
    """
    components = found.shape[0]
    targets = rotated.shape[1] // components
    for m in range(turn.shape[1]):
        cosine, sine = turn[0, m], turn[1, m]
        for n in range(m, turn.shape[1]):
            even, odd = n * n + n + m, n * n + n - m
            if even >= rotated.shape[0]:
                break
            for i in range(components):
                one, other = rotated[even, i * targets + lane], rotated[odd, i * targets + lane]
                found[i, first + even] = cosine * one - sine * other
                if m > 0:
                    found[i, first + odd] = cosine * other + sine * one
