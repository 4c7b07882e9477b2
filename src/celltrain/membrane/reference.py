"""The resting shapes that are known in closed form."""

import numpy as np

from celltrain.harmonics import Profile, Shape, coefficients_of, project_meridian
from celltrain.parameters.reference_shape import BICONCAVE_PROFILE, BICONCAVE_RADIUS


def _biconcave(theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Biconcave disc with its axis along the tube (Evans & Fung 1972).

    rho = a sin(theta),  z = (a/2) (0.207 + 2.003 sin^2 - 1.123 sin^4) cos(theta).

    With the customary digits of a the volume is 4 pi/3 but for a relative excess of 6e-5.
    """
    square = np.sin(theta) ** 2
    constant, second, fourth = BICONCAVE_PROFILE
    height = 0.5 * BICONCAVE_RADIUS * (constant + second * square + fourth * square**2)
    return BICONCAVE_RADIUS * np.sin(theta), height * np.cos(theta)


def _sphere(theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return np.sin(theta), np.cos(theta)


SHAPES = {"biconcave": _biconcave, "sphere": _sphere}


def reference_profile(degree: int, shape: str) -> Profile:
    """Profile, below `degree`, of a resting cell centred at the origin.

    **Arguments:** `shape`: "biconcave" (polynomial of degree 5, so exact for degree >= 6) or
    "sphere" (radius r0).

    **Raises:** `KeyError` for an unknown shape.
    """
    return project_meridian(degree, SHAPES[shape], max(degree, 6) + 4)


def reference_coefficients(degree: int, shape: str) -> Shape:
    """The harmonic coefficients of the same, see `reference_profile`."""
    return coefficients_of(reference_profile(degree, shape))
