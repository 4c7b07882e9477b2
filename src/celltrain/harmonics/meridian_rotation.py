"""Harmonics of given order seen from a pole on the meridian.

With (alpha, beta) polar coordinates about the point (theta, phi = 0), beta = 0 pointing away from
the north pole, and (theta', phi') the same point in the usual ones,

    P_no(theta') cos(o phi') = sum_mu E[n, mu] P_n,mu(alpha) cos(mu beta),
    P_no(theta') sin(o phi') = sum_mu S[n, mu] P_n,mu(alpha) sin(mu beta),
    E, S = d^n_(mu,o)(theta) +- (-1)^mu d^n_(-mu,o)(theta)     (mu > 0; E = d^n_(0,o) for mu = 0),

with Wigner's d, by its recursion in n (Varshalovich, Moskalev & Khersonskii 1988, section 4.8.2):

    n sqrt(((n+1)^2 - mu^2)((n+1)^2 - o^2)) d^(n+1)
        = (2n+1)(n(n+1) cos(theta) - mu o) d^n - (n+1) sqrt((n^2 - mu^2)(n^2 - o^2)) d^(n-1).
"""

from functools import lru_cache

import numpy as np
from jaxtyping import Float
from scipy.special import gammaln

Rotation = Float[np.ndarray, "point degree order"]


@lru_cache(maxsize=512)
def meridian_rotation(
    degree: int, order: int, theta: tuple[float, ...]
) -> tuple[Rotation, Rotation]:
    """E and S of the module for o = `order` and poles at several colatitudes."""
    d = _wigner(degree, order, np.array(theta))
    positive = d[:, :, degree - 1 :]
    sign = np.where(np.arange(degree) % 2 == 0, 1.0, -1.0)
    mirrored = sign * d[:, :, degree - 1 :: -1]
    even, odd = positive + mirrored, positive - mirrored
    even[:, :, 0], odd[:, :, 0] = positive[:, :, 0], 0.0
    found = even, odd
    for each in found:
        each.setflags(write=False)
    return found


def _wigner(
    degree: int, order: int, theta: Float[np.ndarray, " point"]
) -> Float[np.ndarray, "point degree order2"]:
    """d^n_(mu,o)(theta) for mu = 1 - degree ... degree - 1; zero where n < |mu| or n < o."""
    mu = np.arange(1 - degree, degree)
    values = np.zeros((theta.size, degree, mu.size))
    cosine = np.cos(theta)[:, None]
    for n in range(order, degree):
        if n > order:
            before = n - 1
            scale = np.sqrt(np.maximum(n * n - mu * mu, 0.0) * float(n * n - order * order))
            inside = np.abs(mu) < n
            scale = np.where(inside, scale, 1.0)
            if before == 0:  # n = 1 of o = 0: the recursion's own factor vanishes
                step = cosine * values[:, 0] / scale
            else:
                size = np.sqrt(
                    np.maximum(before**2 - mu * mu, 0.0) * float(before**2 - order * order)
                )
                step = (2 * before + 1) * (before * n * cosine - mu * order) * values[:, before]
                step = step - n * size * values[:, before - 1]
                step = step / (before * scale)
            values[:, n] = np.where(inside, step, 0.0)
        starts = [n, -n] if n > order else range(-n, n + 1)
        for m in starts:
            values[:, n, m + degree - 1] = _extreme(n, m, order, theta)
    return values


def _extreme(n: int, m: int, order: int, theta: Float[np.ndarray, " point"]) -> np.ndarray:
    """d^n_(m,o) where |m| or o is n."""
    cosine, sine = np.cos(0.5 * theta), np.sin(0.5 * theta)

    def top(k: int) -> np.ndarray:
        """d^n_(n,k)."""
        size = np.exp(0.5 * (gammaln(2 * n + 1) - gammaln(n + k + 1) - gammaln(n - k + 1)))
        return size * cosine ** (n + k) * (-sine) ** (n - k)

    if m == n:
        return top(order)
    if m == -n:
        return (-1.0) ** (n + order) * top(-order)
    return (-1.0) ** (m - n) * top(m)
