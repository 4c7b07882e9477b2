"""Spectral radius of the linear dynamics about any shapes, by a nonlinear power iteration."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

Vector = Float[np.ndarray, "..."]

# Size of the disturbance (norm of the coefficients): the rates' own error, about 1e-8, and their
# curvature both change the radius by less than a part in a thousand.
DISTURBANCE = 1e-4
ITERATIONS = 50
CONVERGED = 1e-2


@dataclass(frozen=True)
class SpectralRadius:
    """An estimate: the radius in U/r0, the direction that it belongs to, and its cost."""

    radius: float
    direction: Vector
    evaluations: int


def spectral_radius(
    rates: Callable[[Vector], Vector],
    at: Vector,
    rate: Vector,
    direction: Vector,
) -> SpectralRadius:
    """Largest |eigenvalue| of df/dy at y, where f = `rate`, from a direction known before.

    The iteration ends when the estimate changes by less than 1 %. The estimate grows towards the
    radius from below; whoever needs a bound adds a margin.
    """
    direction = direction / np.linalg.norm(direction)
    estimate = 0.0
    for iteration in range(1, ITERATIONS + 1):
        change = (rates(at + DISTURBANCE * direction) - rate) / DISTURBANCE
        previous, estimate = estimate, float(np.linalg.norm(change))
        if not (np.isfinite(estimate) and estimate > 0.0):
            break
        direction = change / estimate
        if iteration > 1 and abs(estimate - previous) < CONVERGED * estimate:
            break
    return SpectralRadius(estimate, direction, iteration)
