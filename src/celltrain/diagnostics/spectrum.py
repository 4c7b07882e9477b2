"""How large a disturbance is, and how it is spread over the harmonics."""

import numpy as np
from jaxtyping import Float

from celltrain.harmonics import Shapes, degree_of, degrees_and_orders
from celltrain.stability import paper_weights


def deformation_spectrum(
    disturbance: Shapes,
) -> Float[np.ndarray, " degree"]:
    """E_n of Eq. (16) of Bryngelson & Freund (2018), in r0^2, for n = 0 ... M - 1.

        E_n = (1/N) sum_j sum_m (a_nm^2 + b_nm^2)   (summed over x, y, z),

    a, b the paper's coefficients (see `paper_weights`).
    """
    degree = degree_of(disturbance)
    n, _ = degrees_and_orders(degree)
    squares = paper_weights(degree) * np.sum(disturbance**2, axis=1).mean(axis=0)
    return np.bincount(n, weights=squares)


def disturbance_amplitude(disturbance: Shapes) -> float:
    """Norm eps of a disturbance of all cells, Eq. (8) of Bryngelson & Freund (2018), in r0.

    eps^2 is the sum of the squares of the paper's coefficients over all cells, N sum_n E_n: the
    printed sum runs to 3 N M^2 and has no factor before it. A displacement of N cells by d, all
    alike, has eps = d sqrt(2 N).
    """
    return float(np.sqrt(len(disturbance) * np.sum(deformation_spectrum(disturbance))))
