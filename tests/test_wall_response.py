"""Flow inside a tube from its velocity on the wall, and rings of force on the wall."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import iv, jv, k0, k1, kv

from celltrain.meridian.bessel import bessel_i, bessel_j, bessel_k
from celltrain.meridian.wall_response import (
    response,
    ring_velocity,
    uniform_response,
    uniform_ring_velocity,
)

RADIUS = 1.7
NUMBERS = (0, 1, 2, 3, 7)
WAVES = np.array([0.02, 0.6, 3.0, 11.0])


def inside(m: int, wave: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, ...]:
    regular = bessel_i(np.outer(wave, places), m + 3)
    return response(m, wave, RADIUS, places, regular, bessel_i(wave * RADIUS, m + 3))


def rings(m: int, wave: np.ndarray) -> np.ndarray:
    x = wave * RADIUS
    return ring_velocity(m, wave, RADIUS, bessel_i(x, m + 3), bessel_k(x, m + 3))


def test_bessel_functions_of_all_orders() -> None:
    x = np.array([1e-6, 0.01, 1.0, 7.3, 60.0, 190.0])
    orders = np.arange(12)[:, None]
    assert_allclose(bessel_j(x, 12), jv(orders, x), rtol=0, atol=3e-15)
    assert_allclose(bessel_i(x, 12), np.exp(-x) * iv(orders, x), rtol=1e-12)
    assert_allclose(bessel_k(x[1:], 12), np.exp(x[1:]) * kv(orders, x[1:]), rtol=1e-12)
    assert bessel_j(np.array([0.0]), 3).ravel().tolist() == [1.0, 0.0, 0.0]


@pytest.mark.parametrize("m", NUMBERS)
def test_unit_velocities_on_the_wall(m: int) -> None:
    edge = np.array([RADIUS])
    value, _, _ = inside(m, WAVES, edge)
    unit = np.broadcast_to(np.eye(3), (WAVES.size, 3, 3))
    assert_allclose(value[..., 0], unit, rtol=0, atol=1e-12)
    still, _, _ = uniform_response(m, RADIUS, edge)
    # No flow through the wall along its whole length, so none inside.
    assert_allclose(still[0, ..., 0], np.diag([float(m > 0), 1.0, 1.0]), rtol=0, atol=1e-13)


def chebyshev(low: float, high: float, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Points and the matrix that differentiates at them."""
    place = np.arange(count)
    x = np.cos(np.pi * place / (count - 1))
    size = np.where((place == 0) | (place == count - 1), 2.0, 1.0) * (-1.0) ** place
    apart = x[:, None] - x + np.eye(count)
    matrix = np.outer(size, 1.0 / size) / apart
    matrix -= np.diag(matrix.sum(axis=1))
    return low + 0.5 * (x + 1.0) * (high - low), matrix * 2.0 / (high - low)


@pytest.mark.parametrize("wave", [0.0, 0.4, 3.0])
@pytest.mark.parametrize("m", NUMBERS)
def test_flow_inside_satisfies_the_equations_of_stokes(m: int, wave: float) -> None:
    r, slope_of = chebyshev(0.3, RADIUS, 28)
    found = inside(m, np.array([wave]), r) if wave else uniform_response(m, RADIUS, r)
    value, slope, pressure = (each[0] for each in found)
    for wall in range(3):
        radial, around, axial = value[wall]
        slopes = value[wall] @ slope_of.T
        assert_allclose(slope[wall], slopes, rtol=0, atol=1e-10 * (1 + np.abs(slopes).max()))
        size = 1.0 + np.abs(slopes @ slope_of.T).max()

        def laplacian(field: np.ndarray) -> np.ndarray:
            first = slope_of @ field
            return slope_of @ first + first / r - (m**2 / r**2 + wave**2) * field

        p = pressure[wall]
        balances = [
            slopes[0] + radial / r + m * around / r - wave * axial,
            laplacian(radial) - (radial + 2 * m * around) / r**2 - slope_of @ p,
            laplacian(around) - (around + 2 * m * radial) / r**2 + m * p / r,
            laplacian(axial) - wave * p,
        ]
        assert_allclose(balances, 0.0, atol=1e-8 * size)


def quadrature_of_rings(m: int, wave: float) -> np.ndarray:
    """(1/4 pi) int G f exp(i (m phi + k z)) dphi dz at phi = z = 0, graded towards the target."""
    nodes, weights = np.polynomial.legendre.leggauss(160)
    t = 0.5 * (nodes + 1)
    phi, weights = np.pi * t**8, 0.5 * weights * 8 * np.pi * t**7
    phi, weights = np.concatenate([phi, -phi]), np.concatenate([weights, weights])
    d = RADIUS * np.array([1 - np.cos(phi), -np.sin(phi)])
    # Without rounding near the target.
    d[0] = 2 * RADIUS * np.sin(0.5 * phi) ** 2
    apart = 2 * RADIUS * np.abs(np.sin(0.5 * phi))
    x = wave * apart
    kernel = np.zeros((3, 3, phi.size), dtype=complex)
    kernel[:2, :2] = 2 * k0(x) * np.eye(2)[..., None] + 2 * wave * k1(x) / apart * d[:, None] * d
    kernel[2, :2] = kernel[:2, 2] = -2j * wave * k0(x) * d
    kernel[2, 2] = 4 * k0(x) - 2 * x * k1(x)
    cosine, sine, none, one = np.cos(phi), np.sin(phi), 0 * phi, 1 + 0 * phi
    fields = np.array(
        [[cosine, sine, none], [1j * sine, -1j * cosine, none], [none, none, 1j * one]]
    )
    turning = weights * np.exp(1j * m * phi) / (4 * np.pi)
    x, y, z = np.einsum("ijp,fjp,p->if", kernel, fields, turning)
    return np.stack([x, 1j * y, -1j * z])


@pytest.mark.parametrize("wave", [0.05, 0.6, 4.0])
@pytest.mark.parametrize("m", NUMBERS)
def test_rings_of_force_by_quadrature(m: int, wave: float) -> None:
    found = rings(m, np.array([wave]))[0]
    expected = quadrature_of_rings(m, wave)
    assert_allclose(expected.imag, 0.0, atol=1e-12)
    assert_allclose(found, expected.real, rtol=0, atol=1e-11)


@pytest.mark.parametrize("m", NUMBERS)
def test_rings_of_force_are_reciprocal(m: int) -> None:
    found = rings(m, np.array([0.01, 0.5, 20.0]))
    assert_allclose(found, found.transpose(0, 2, 1), rtol=0, atol=1e-9 * np.abs(found).max())
    still = uniform_ring_velocity(m)[0]
    assert_allclose(still, still.T, rtol=0, atol=0)


@pytest.mark.parametrize("m", NUMBERS)
def test_long_waves_become_the_uniform_one(m: int) -> None:
    wave, places = np.array([1e-4]), np.array([0.3, 1.0, 1.5])
    value, slope, pressure = inside(m, wave, places)
    still = uniform_response(m, RADIUS, places)
    found = rings(m, wave)[0]
    limit = uniform_ring_velocity(m)[0]
    if m == 0:
        # Of the others a long wave's flow along the tube turns back, and rings have a resultant.
        assert_allclose(value[0, 1], still[0][0, 1], rtol=1e-6)
        assert_allclose(found[1, 1], limit[1, 1], rtol=1e-6)
        return
    assert_allclose(value, still[0], rtol=0, atol=1e-3)
    assert_allclose(slope, still[1], rtol=0, atol=1e-3)
    assert_allclose(pressure, still[2], rtol=0, atol=1e-3)
    # Of m = 1 only the forces without a resultant across the tube.
    free = np.eye(3) if m > 1 else np.array([[1.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    assert_allclose(free.T @ found @ free, free.T @ limit @ free, rtol=0, atol=1e-3)
