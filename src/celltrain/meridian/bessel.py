"""Bessel functions of all orders at once, by recurrence (Abramowitz & Stegun 1964, 9.12, 9.6).

J_n and I_n by Miller's downward recurrence, normalised by 1 = J_0 + 2 sum J_2k and
exp(x) = I_0 + 2 sum I_k; K_n upward from K_0 and K_1. SciPy's functions, order by order, would take
most of the time of a train's wall.
"""

from typing import no_type_check

import numpy as np
from jaxtyping import Float
from numba import njit
from scipy.special import k0e, k1e

# Below this the recurrence divides by too small a number; the series' first terms are exact.
TINY = 1e-8


def bessel_j(x: Float[np.ndarray, " *point"], orders: int) -> Float[np.ndarray, "order *point"]:
    """J_n(x) for n < `orders` and x >= 0."""
    return _bessel_j(np.ravel(x), orders - 1).reshape(orders, *np.shape(x))


def bessel_i(x: Float[np.ndarray, " *point"], orders: int) -> Float[np.ndarray, "order *point"]:
    """exp(-x) I_n(x) for n < `orders` and x > 0."""
    return _bessel_i(np.ravel(x), orders - 1).reshape(orders, *np.shape(x))


def bessel_k(x: Float[np.ndarray, " point"], orders: int) -> Float[np.ndarray, "order point"]:
    """exp(x) K_n(x) for n < `orders` and x > 0."""
    found = np.empty((max(orders, 2), x.size))
    found[0], found[1] = k0e(x), k1e(x)
    for n in range(1, orders - 1):
        found[n + 1] = found[n - 1] + 2.0 * n / x * found[n]
    return found[:orders]


@njit(cache=True)
@no_type_check
def _bessel_j(x, largest):
    found = np.zeros((largest + 1, x.size))
    for p in range(x.size):
        if x[p] < TINY:
            found[0, p] = 1.0
            if largest > 0:
                found[1, p] = 0.5 * x[p]
            continue
        start = int(max(largest, x[p] + 8.0 * x[p] ** (1.0 / 3.0)) + 22)
        start += start % 2
        above, here, total = 0.0, 1e-280, 0.0
        for n in range(start, 0, -1):
            if n <= largest:
                found[n, p] = here
            if n % 2 == 0:
                total += 2.0 * here
            below = 2.0 * n / x[p] * here - above
            above, here = here, below
            if abs(here) > 1e200:
                here *= 1e-200
                above *= 1e-200
                total *= 1e-200
                for k in range(n, largest + 1):
                    found[k, p] *= 1e-200
        found[0, p] = here
        scale = 1.0 / (total + here)
        for n in range(largest + 1):
            found[n, p] *= scale
    return found


@njit(cache=True)
@no_type_check
def _bessel_i(x, largest):
    found = np.empty((largest + 1, x.size))
    for p in range(x.size):
        start = int(largest + 8 + np.sqrt(80.0 * x[p] + 60.0))
        above, here, total = 0.0, 1e-280, 0.0
        for n in range(start, 0, -1):
            if n <= largest:
                found[n, p] = here
            total += 2.0 * here
            below = above + 2.0 * n / x[p] * here
            above, here = here, below
            if here > 1e200:
                here *= 1e-200
                above *= 1e-200
                total *= 1e-200
                for k in range(n, largest + 1):
                    found[k, p] *= 1e-200
        found[0, p] = here
        scale = 1.0 / (total + here)
        for n in range(largest + 1):
            found[n, p] *= scale
    return found
