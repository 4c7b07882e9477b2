"""The resting shapes that are known in closed form."""

import numpy as np
from jaxtyping import Float

from celltrain.harmonics import real_harmonics, unit_vectors
from celltrain.harmonics.grid import sphere_grid
from celltrain.parameters.reference_shape import BICONCAVE_PROFILE, BICONCAVE_RADIUS


def _biconcave(theta: np.ndarray, phi: np.ndarray) -> np.ndarray:
    """Biconcave disc with its axis along the tube (Evans & Fung 1972).

    rho = a sin(theta),  z = (a/2) (0.207 + 2.003 sin^2 - 1.123 sin^4) cos(theta).

    With the customary digits of a the volume is 4 pi/3 but for a relative excess of 6e-5.
    """
    square = np.sin(theta) ** 2
    constant, second, fourth = BICONCAVE_PROFILE
    radius = BICONCAVE_RADIUS * np.sin(theta)
    height = 0.5 * BICONCAVE_RADIUS * (constant + second * square + fourth * square**2)
    return np.stack([radius * np.cos(phi), radius * np.sin(phi), height * np.cos(theta)])


def _sphere(theta: np.ndarray, phi: np.ndarray) -> np.ndarray:
    return unit_vectors(theta, phi).T


SHAPES = {"biconcave": _biconcave, "sphere": _sphere}


def reference_coefficients(degree: int, shape: str) -> Float[np.ndarray, "3 coefficient"]:
    """Harmonic coefficients, below `degree`, of a resting cell centred at the origin.

    **Arguments:** `shape`: "biconcave" (polynomial of degree 5, so exact for degree >= 6) or
    "sphere" (radius r0).

    **Raises:** `KeyError` for an unknown shape.
    """
    grid = sphere_grid(degree, max(degree, 6) + 4)
    theta, phi = grid.points()
    weights = np.asarray(grid.weights)
    return SHAPES[shape](theta, phi) * weights @ real_harmonics(degree, theta, phi)
