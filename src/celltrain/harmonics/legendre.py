"""Normalised associated Legendre functions of colatitude, and their derivatives.

P_no(theta), without the Condon-Shortley sign, scaled such that the real harmonics made of them are
orthonormal on the unit sphere: int P_no^2 sin(theta) dtheta = 1/(2 pi).
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

#: By order o, degree n and point; zero where n < o.
Table = Float[np.ndarray, "order degree point"]


@dataclass(frozen=True)
class LegendreTables:
    """P_no, dP_no/dtheta and d^2 P_no/dtheta^2 at fixed colatitudes, none of them a pole."""

    value: Table
    slope: Table
    curvature: Table


def legendre_functions(
    degree: int, largest_order: int, theta: Float[np.ndarray, " point"]
) -> Table:
    """P_no(theta) for n < `degree` and o = 0 ... `largest_order`, by the stable recursion in n."""
    cosine, sine = np.cos(theta), np.sin(theta)
    values = np.zeros((largest_order + 1, degree, theta.size))
    diagonal = np.full(theta.size, np.sqrt(0.25 / np.pi))
    for o in range(min(largest_order, degree - 1) + 1):
        if o > 0:
            diagonal = np.sqrt((2 * o + 1) / (2 * o)) * sine * diagonal
        values[o, o] = diagonal
        for n in range(o + 1, degree):
            scale = np.sqrt((4 * n * n - 1) / (n * n - o * o))
            values[o, n] = scale * cosine * values[o, n - 1]
            if n > o + 1:
                previous = np.sqrt(((n - 1) ** 2 - o * o) / (4 * (n - 1) ** 2 - 1))
                values[o, n] -= scale * previous * values[o, n - 2]
    return values


def legendre_tables(
    degree: int, largest_order: int, theta: Float[np.ndarray, " point"]
) -> LegendreTables:
    """The functions with their first two derivatives.

    The first follows from the neighbours in o, the second from Legendre's equation,
    P'' = -cot(theta) P' - (n (n + 1) - o^2/sin^2(theta)) P.
    """
    values = legendre_functions(degree, largest_order + 1, theta)
    slope = np.zeros((largest_order + 1, *values.shape[1:]))
    n = np.arange(degree)
    for o in range(largest_order + 1):
        above = np.sqrt(np.maximum((n - o) * (n + o + 1.0), 0.0))[:, None] * values[o + 1]
        if o == 0:
            slope[o] = -above
            continue
        below = np.sqrt(np.maximum((n + o) * (n - o + 1.0), 0.0))[:, None] * values[o - 1]
        slope[o] = 0.5 * (below - above) * (n >= o)[:, None]
    values = values[:-1]
    order = np.arange(largest_order + 1)[:, None, None]
    level = (n * (n + 1.0))[:, None] - (order / np.sin(theta)) ** 2
    return LegendreTables(values, slope, -slope / np.tan(theta) - level * values)
