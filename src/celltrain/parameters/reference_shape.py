"""The measures of the resting cell that decide whether a case makes sense.

The biconcave shape of Evans & Fung (1972), scaled to the volume 4 pi/3 of a sphere of radius r0:
distance from its axis a sin(th), height (a/2)(0.207 + 2.003 sin^2(th) - 1.123 sin^4(th)) cos(th).
"""

import math

#: Largest radius of the biconcave cell, r0, which makes its volume 4 pi/3.
BICONCAVE_RADIUS = 1.38581894

#: Coefficients of 1, sin^2, sin^4 in the height of the biconcave cell over a/2 cos(th).
BICONCAVE_PROFILE = (0.207, 2.003, -1.123)


def resting_diameter(reference: str) -> float:
    """Largest diameter across the axis of the resting cell, r0."""
    return 2 * BICONCAVE_RADIUS if reference == "biconcave" else 2.0


def resting_thickness(reference: str) -> float:
    """Largest axial thickness of the resting cell at one distance from its axis, r0.

    Copies of the cell on one axis overlap when they are closer than this.
    """
    if reference != "biconcave":
        return 2.0
    constant, square, fourth = BICONCAVE_PROFILE
    # With c = cos(th) the height over a/2 is a polynomial in c, largest where its slope is zero:
    # a quadratic equation for c^2, whose other root is negative.
    linear, cubic = constant + square + fourth, -square - 2 * fourth
    cosine = math.sqrt(
        (-3 * cubic - math.sqrt(9 * cubic**2 - 20 * fourth * linear)) / (10 * fourth)
    )
    return BICONCAVE_RADIUS * (linear * cosine + cubic * cosine**3 + fourth * cosine**5)
