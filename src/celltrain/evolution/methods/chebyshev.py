"""The Runge-Kutta-Chebyshev method of second order, as formulas for any system dy/dt = f(y).

An explicit method of s stages whose interval of stability on the negative real axis has the
length 0.653 (s^2 - 1): the stiffness of the membranes, whose fast modes decay without oscillating,
costs the square root of what it costs a method with fixed stages (Sommeijer, Shampine & Verwer
1998).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

Vector = Float[np.ndarray, "..."]
Rates = Callable[[Vector], Vector]

# Damping of the Chebyshev polynomials: a strip about the real axis belongs to the stable region.
DAMPING = 2.0 / 13.0
# Square of the stages per length of the interval of stability, with the margin of the RKC code.
STAGES_SQUARED = 1.54


@dataclass(frozen=True)
class Stage:
    """Coefficients of W_j = mu W_{j-1} + nu W_{j-2} + (1 - mu - nu) W_0 + h (m F_{j-1} + g F_0)."""

    mu: float
    nu: float
    rate: float
    first_rate: float


def stage_count(step: float, radius: float) -> int:
    """Fewest stages, at least 2, that keep a step stable when no |eigenvalue| exceeds `radius`."""
    return max(2, 1 + math.floor(math.sqrt(STAGES_SQUARED * step * radius + 1.0)))


def largest_stable_step(stages: int, radius: float) -> float:
    """Longest step (to rounding) for which `stage_count` gives no more than so many stages."""
    return (1.0 - 1e-9) * (stages**2 - 1) / (STAGES_SQUARED * radius)


def chebyshev_stages(stages: int) -> tuple[float, list[Stage]]:
    """Coefficient of the first stage, W_1 = W_0 + h m F_0, and those of the stages 2 to s >= 2.

    With T the Chebyshev polynomials, w0 = 1 + eps/s^2, w1 = T_s'(w0)/T_s''(w0),
    b_j = T_j''(w0)/T_j'(w0)^2, b_0 = b_1 = b_2 and a_j = 1 - b_j T_j(w0):
    mu = 2 b_j w0/b_{j-1}, nu = -b_j/b_{j-2}, m = 2 b_j w1/b_{j-1}, g = -a_{j-1} m.
    """
    w0 = 1.0 + DAMPING / stages**2
    values, slopes, curvatures = [1.0, w0], [0.0, 1.0], [0.0, 0.0]
    for _ in range(2, stages + 1):
        values.append(2.0 * w0 * values[-1] - values[-2])
        curvatures.append(2.0 * w0 * curvatures[-1] - curvatures[-2] + 4.0 * slopes[-1])
        slopes.append(2.0 * w0 * slopes[-1] - slopes[-2] + 2.0 * values[-2])
    w1 = slopes[stages] / curvatures[stages]
    b = [curvatures[j] / slopes[j] ** 2 for j in range(2, stages + 1)]
    b = [b[0], b[0], *b]
    found = []
    for j in range(2, stages + 1):
        rate = 2.0 * b[j] * w1 / b[j - 1]
        found.append(
            Stage(
                mu=2.0 * b[j] * w0 / b[j - 1],
                nu=-b[j] / b[j - 2],
                rate=rate,
                first_rate=-(1.0 - b[j - 1] * values[j - 1]) * rate,
            )
        )
    return b[1] * w1, found


def chebyshev_step(rates: Rates, start: Vector, first: Vector, step: float, stages: int) -> Vector:
    """y(t + h) of dy/dt = f(y) from y(t) = `start`, where f = `first`; s - 1 evaluations of f."""
    entry, others = chebyshev_stages(stages)
    before, here = start, start + step * entry * first
    for stage in others:
        along = stage.rate * rates(here) + stage.first_rate * first
        rest = 1.0 - stage.mu - stage.nu
        before, here = here, stage.mu * here + stage.nu * before + rest * start + step * along
    return here


def embedded_error(start: Vector, first: Vector, end: Vector, last: Vector, step: float) -> Vector:
    """Estimated local error of a step from values and rates at both ends; it falls as h^3."""
    return 0.8 * (start - end) + 0.4 * step * (first + last)
