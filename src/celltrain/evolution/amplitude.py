"""How large a disturbance of a whole train is."""

import numpy as np
from jaxtyping import Float

from celltrain.harmonics import degrees_and_orders

Disturbed = Float[np.ndarray, "cell 3 coefficient"]


def paper_weights(degree: int) -> Float[np.ndarray, " coefficient"]:
    """Square of the paper's coefficient over that of the orthonormal one.

    1/(2 pi) for order 0 and 1/pi otherwise (see `celltrain.stability.PaperNorm`).
    """
    _, order = degrees_and_orders(degree)
    return np.where(order == 0, 0.5, 1.0) / np.pi


def amplitude(disturbance: Disturbed) -> float:
    """eps, Eq. (8) of Bryngelson & Freund (2018), in r0.

    The root of the sum of squares of the paper's coefficients over all cells and directions, as in
    `celltrain.stability.PaperNorm`: the printed sum runs to 3 N M^2 and has no factor before it. A
    displacement of N cells by d, all alike, has eps = d sqrt(2 N).
    """
    degree = int(np.sqrt(disturbance.shape[-1]))
    return float(np.sqrt(np.sum(paper_weights(degree) * disturbance**2)))
