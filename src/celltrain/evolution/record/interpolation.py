"""States within a step."""

import numpy as np
from jaxtyping import Float

Vector = Float[np.ndarray, "..."]


def interpolated(
    time: float,
    begin: tuple[float, Vector, Vector],
    end: tuple[float, Vector, Vector],
) -> Vector:
    """Value at a time within a step, from (time, value, rate) at both ends: the cubic polynomial.

    Its error falls as h^4, faster than the method's own.
    """
    (t0, y0, f0), (t1, y1, f1) = begin, end
    step = t1 - t0
    s = (time - t0) / step
    rise = y1 - y0
    return y0 + s * rise + s * (1.0 - s) * ((1.0 - s) * (step * f0 - rise) - s * (step * f1 - rise))
