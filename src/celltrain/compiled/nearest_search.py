"""Newton's method for the nearest point of a surface, one pair after the other, for Numba.

The same steps as those in `proximity.nearest`, which says what they are; there all pairs of a chunk
go on until the last has ended, and bring whole shapes to a new pole each time. Here the surface and
its derivatives follow from Legendre functions at the point itself. With P_no those of order o >= 0,
in coordinates xi_1 along theta and xi_2 along phi,

    x_1 = P', x_11 = P'', x_2 = o P/sin, x_12 = (o P/sin)', x_11 + x_22 = -n (n + 1) P,

each times the longitude's part. All come from the neighbours of P in n and o, so that no pole is
singular.
"""

import math
from typing import Any

import numpy as np

from celltrain.parts import FAST, part

#: Columns of what is found: theta, phi, distance with its sign, stretch, whether it converged.
FOUND = 5

#: Bounds on the steps (radian) and their number.
MAX_ITERATIONS = 30
LONGEST_STEP = 0.3
SHORTEST_STEP = 1e-9
# Factors of the recursions, by order and degree: of P from the two lower degrees, of derivatives
# from the orders above and below, of o P/sin from the same of the next lower degree.
_SCALE, _PREVIOUS, _ABOVE, _BELOW, _SHIFTED_ABOVE, _SHIFTED_BELOW, _FACTORS = range(7)
# Functions: P, its two derivatives, o P/sin and its derivative, and what -x_11 - x_22 is of.
_VALUE, _SLOPE, _CURVATURE, _ACROSS, _ACROSS_SLOPE, _LEVEL, FUNCTIONS = range(7)


@part(inline="always")
def search_factors(degree: int) -> Any:
    """Factors of the recursions, [factor, order, degree]."""
    made = np.zeros((_FACTORS, degree + 1, degree))
    for o in range(degree):
        for n in range(o, degree):
            if n > o:
                made[_SCALE, o, n] = math.sqrt((4.0 * n * n - 1.0) / (n * n - o * o))
            if n > o + 1:
                below = float(n - 1)
                made[_PREVIOUS, o, n] = made[_SCALE, o, n] * math.sqrt(
                    (below * below - o * o) / (4.0 * below * below - 1.0)
                )
            # Order 0 has order 1 on both sides.
            half = 0.5 if o > 0 else 1.0
            made[_ABOVE, o, n] = half * math.sqrt((n - o) * (n + o + 1.0))
            if o > 0:
                made[_BELOW, o, n] = 0.5 * math.sqrt((n + o) * (n - o + 1.0))
                shifted = 0.5 * math.sqrt((2.0 * n + 1.0) / (2.0 * n - 1.0))
                made[_SHIFTED_ABOVE, o, n] = shifted * math.sqrt((n - o) * (n - o - 1.0))
                made[_SHIFTED_BELOW, o, n] = shifted * math.sqrt((n + o) * (n + o - 1.0))
    return made


@part(inline="always")
def arranged_shapes(shapes: Any, degree: int) -> Any:
    """Coefficients by order, sine or cosine, axis and degree, [cell, order, 2, 3, degree]."""
    made = np.zeros((shapes.shape[0], degree, 2, 3, degree))
    for cell in range(shapes.shape[0]):
        for o in range(degree):
            scale = math.sqrt(2.0) if o > 0 else 1.0
            for i in range(3):
                for n in range(o, degree):
                    middle = n * n + n
                    made[cell, o, 0, i, n] = scale * shapes[cell, i, middle + o]
                    if o > 0:
                        made[cell, o, 1, i, n] = scale * shapes[cell, i, middle - o]
    return made


@part(fastmath=FAST, inline="always")
def _tabulate(theta: float, factors: Any, functions: Any) -> None:
    """The functions at a colatitude, [function, order, degree]; order `degree` stays zero."""
    degree = factors.shape[2]
    cosine, sine = math.cos(theta), math.sin(theta)
    value, slope, curvature = functions[_VALUE], functions[_SLOPE], functions[_CURVATURE]
    across, across_slope = functions[_ACROSS], functions[_ACROSS_SLOPE]
    diagonal = math.sqrt(0.25 / math.pi)
    for o in range(degree):
        if o > 0:
            diagonal *= math.sqrt((2.0 * o + 1.0) / (2.0 * o)) * sine
        value[o, o] = diagonal
        for n in range(o + 1, degree):
            value[o, n] = factors[_SCALE, o, n] * cosine * value[o, n - 1]
            if n > o + 1:
                value[o, n] -= factors[_PREVIOUS, o, n] * value[o, n - 2]
    for before, after in ((value, slope), (slope, curvature)):
        for n in range(degree):
            after[0, n] = -factors[_ABOVE, 0, n] * before[1, n]
        for o in range(1, degree):
            for n in range(o, degree):
                after[o, n] = (
                    factors[_BELOW, o, n] * before[o - 1, n]
                    - factors[_ABOVE, o, n] * before[o + 1, n]
                )
    for before, after in ((value, across), (slope, across_slope)):
        for o in range(1, degree):
            for n in range(o, degree):
                after[o, n] = (
                    factors[_SHIFTED_ABOVE, o, n] * before[o + 1, n - 1]
                    + factors[_SHIFTED_BELOW, o, n] * before[o - 1, n - 1]
                )
    for o in range(degree):
        for n in range(o, degree):
            functions[_LEVEL, o, n] = n * (n + 1.0) * value[o, n]


@part(fastmath=FAST)
def _jet(theta: float, phi: float, shape: Any, factors: Any, functions: Any, jet: Any) -> None:
    """x, x_1, x_2, x_11, x_12 and x_22 of a surface, [6, 3]."""
    degree = factors.shape[2]
    _tabulate(theta, factors, functions)
    jet[:] = 0.0
    for o in range(degree):
        cosine, sine = math.cos(o * phi), math.sin(o * phi)
        for side in range(2):
            along, turned = (cosine, -sine) if side == 0 else (sine, cosine)
            for i in range(3):
                x = x1 = x2 = x11 = x12 = level = 0.0
                coefficients = shape[o, side, i]
                for n in range(o, degree):
                    c = coefficients[n]
                    x += functions[_VALUE, o, n] * c
                    x1 += functions[_SLOPE, o, n] * c
                    x2 += functions[_ACROSS, o, n] * c
                    x11 += functions[_CURVATURE, o, n] * c
                    x12 += functions[_ACROSS_SLOPE, o, n] * c
                    level += functions[_LEVEL, o, n] * c
                jet[0, i] += along * x
                jet[1, i] += along * x1
                jet[2, i] += turned * x2
                jet[3, i] += along * x11
                jet[4, i] += turned * x12
                jet[5, i] -= along * level
    for i in range(3):
        jet[5, i] -= jet[3, i]


@part()
def _product(a: Any, b: Any) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@part(inline="always")
def _newton_step(jet: Any, away: Any) -> tuple[float, float]:
    """Newton's step where the Hessian is positive, Gauss and Newton's where it is not."""
    g, h = _product(jet[1], away), _product(jet[2], away)
    a, b, c = _product(jet[1], jet[1]), _product(jet[1], jet[2]), _product(jet[2], jet[2])
    p = a + _product(jet[3], away)
    q = b + _product(jet[4], away)
    r = c + _product(jet[5], away)
    if p * r - q * q > 0.05 * (a * c - b * b) and p + r > 0.0:
        a, b, c = p, q, r
    area = a * c - b * b
    first, second = -(c * g - b * h) / area, -(a * h - b * g) / area
    shorter = min(1.0, LONGEST_STEP / max(math.hypot(first, second), 1e-300))
    return first * shorter, second * shorter


@part(inline="always")
def _moved(theta: float, phi: float, first: float, second: float) -> tuple[float, float]:
    """The place moved by (xi_1, xi_2) along a great circle."""
    angle = math.hypot(first, second)
    ratio = math.sin(angle) / angle if angle > 0.0 else 1.0
    across, along, up = ratio * first, ratio * second, math.cos(angle)
    x = math.cos(theta) * across + math.sin(theta) * up
    z = math.cos(theta) * up - math.sin(theta) * across
    return math.atan2(math.hypot(x, along), z), phi + math.atan2(along, x)


@part()
def search_one(
    point: Any, shape: Any, guess: Any, factors: Any, functions: Any, jets: Any, found: Any
) -> None:
    """One pair's nearest point; `jets` is room for two."""
    theta, phi, square = guess[0], guess[1], math.inf
    new_theta, new_phi, shortening, ended = theta, phi, 1.0, False
    jet, trial, away = jets[0], jets[1], np.empty(3)
    for iteration in range(MAX_ITERATIONS + 1):
        _jet(new_theta, new_phi, shape, factors, functions, trial)
        new_square = 0.0
        for i in range(3):
            new_square += (trial[0, i] - point[i]) ** 2
        if iteration == 0 or new_square <= square:
            theta, phi, square, shortening = new_theta, new_phi, new_square, 1.0
            jet, trial = trial, jet
            for i in range(3):
                away[i] = jet[0, i] - point[i]
        else:
            shortening *= 0.25
        if ended or iteration == MAX_ITERATIONS:
            break
        first, second = _newton_step(jet, away)
        first, second = shortening * first, shortening * second
        ended = math.hypot(first, second) < SHORTEST_STEP
        new_theta, new_phi = _moved(theta, phi, first, second)
    one, two = jet[1], jet[2]
    through = -(
        (one[1] * two[2] - one[2] * two[1]) * away[0]
        + (one[2] * two[0] - one[0] * two[2]) * away[1]
        + (one[0] * two[1] - one[1] * two[0]) * away[2]
    )
    a, b, c = _product(one, one), _product(one, two), _product(two, two)
    distance = math.sqrt(square)
    found[0], found[1] = theta, phi
    found[2] = distance if through >= 0.0 else -distance
    found[3] = math.sqrt(0.5 * (a + c) + math.hypot(0.5 * (a - c), b))
    found[4] = 1.0 if ended else 0.0
