"""Functionals of a membrane's forces under displacements, against differences of places."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain.meridian.functionals import moved, stressed

R = np.array([0.4, 0.9, 1.5])
Z = np.array([-0.3, 0.2, 1.1])
AXIAL, RADIAL = np.array([0.7, -1.2, 0.4]), np.array([0.5, 0.8, -0.9])
PRESSURE = np.array([0.3, -0.6, 1.4])


def amplitudes(r: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Some l_R, l_Phi, l_Z."""
    return np.stack([np.sin(r) * np.exp(0.3 * z), r**2 * np.cos(z), np.exp(-r) * (1 + z**2)])


def slopes(r: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    h = 1e-20
    return amplitudes(r + 1j * h, z).imag / h, amplitudes(r, z + 1j * h).imag / h


def functional(m: int, place: np.ndarray) -> np.ndarray:
    """l e^{-im phi} at a place, by Cartesian components: l.f = l_R R + l_Phi Phi + l_Z Z."""
    x, y, z = place
    r, phi = np.hypot(x, y), np.arctan2(y, x)
    radial, around, axial = amplitudes(r, z)
    around = 1j * around
    cosine, sine = np.cos(phi), np.sin(phi)
    cartesian = np.stack([radial * cosine - around * sine, radial * sine + around * cosine, axial])
    return cartesian * np.exp(-1j * m * phi)


def displacement(component: int, m: int, phi: float) -> np.ndarray:
    """A unit of R, Phi or Z at a longitude."""
    r, p, z = np.eye(3)[component] * np.exp(1j * m * phi)
    p = -1j * p
    cosine, sine = np.cos(phi), np.sin(phi)
    return np.array([r * cosine - p * sine, r * sine + p * cosine, z])


@pytest.mark.parametrize("m", [0, 1, 2, 5])
@pytest.mark.parametrize("kind", ["moved", "stressed"])
def test_functionals_by_differences(kind: str, m: int) -> None:
    value, (radial_slope, axial_slope) = amplitudes(R, Z), slopes(R, Z)
    vector = (AXIAL, RADIAL)
    if kind == "moved":
        found = moved(value, radial_slope, axial_slope, m, R, vector)
    else:
        found = stressed(value, radial_slope, axial_slope, PRESSURE, m, R, vector)
    h, phi = 1e-4, 0.8
    for point in range(len(R)):
        place = np.array([R[point] * np.cos(phi), R[point] * np.sin(phi), Z[point]])
        content = np.array([RADIAL[point] * np.cos(phi), RADIAL[point] * np.sin(phi), AXIAL[point]])
        gradient = np.stack(
            [
                (
                    8 * functional(m, place + h * axis)
                    - 8 * functional(m, place - h * axis)
                    - functional(m, place + 2 * h * axis)
                    + functional(m, place - 2 * h * axis)
                )
                / (12 * h)
                for axis in np.eye(3)
            ]
        )  # [k, j]: d_k l_j
        for component in range(3):
            u = displacement(component, m, phi)
            expected = u @ gradient @ content
            if kind == "stressed":
                pressure = PRESSURE[point] * np.exp(-1j * m * phi)
                expected += content @ gradient @ u - pressure * (u @ content)
            assert_allclose(found[component, point], expected, rtol=0, atol=2e-10)
