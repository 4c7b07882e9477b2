"""Shapes of the resting cell that are known beforehand, and the measures of a meridian.

The biconcave shape of Evans & Fung (1972), scaled to the volume 4 pi/3 of a sphere of radius r0:
distance from its axis a sin(th), height (a/2)(0.207 + 2.003 sin^2(th) - 1.123 sin^4(th)) cos(th).
"""

import numpy as np

#: Largest radius of the biconcave cell, r0, which makes its volume 4 pi/3.
BICONCAVE_RADIUS = 1.38581894

#: Coefficients of 1, sin^2, sin^4 in the height of the biconcave cell over a/2 cos(th).
BICONCAVE_PROFILE = (0.207, 2.003, -1.123)


def spheroid_axes(aspect_ratio: float) -> tuple[float, float]:
    """Semi-axes across and along the axis, r0, of the spheroid of volume 4 pi/3."""
    radius = aspect_ratio ** (-1 / 3)
    return radius, aspect_ratio * radius


def profile_measures(points: np.ndarray) -> tuple[float, float]:
    """Diameter and thickness of a surface of revolution from points of its meridian."""
    rho, z = points.T
    levels = np.linspace(0.0, rho.max(), 401)
    top, bottom = np.full_like(levels, -np.inf), np.full_like(levels, np.inf)
    for i in range(len(rho) - 1):
        ends = sorted(((rho[i], z[i]), (rho[i + 1], z[i + 1])))
        here = (levels >= ends[0][0]) & (levels <= ends[1][0])
        height = np.interp(levels[here], [ends[0][0], ends[1][0]], [ends[0][1], ends[1][1]])
        top[here], bottom[here] = np.maximum(top[here], height), np.minimum(bottom[here], height)
    known = np.isfinite(top)
    return 2.0 * float(rho.max()), float((top[known] - bottom[known]).max())
