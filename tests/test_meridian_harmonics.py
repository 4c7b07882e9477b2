"""Harmonics along a meridian: Legendre functions, fields of one azimuthal number, rotations."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain.harmonics import azimuthal_basis, azimuthal_weight, real_harmonics
from celltrain.harmonics.azimuthal import cylindrical_members, member_count
from celltrain.harmonics.legendre import legendre_functions, legendre_tables
from celltrain.harmonics.meridian_rotation import meridian_rotation

DEGREE = 7
THETA = np.array([0.05, 0.4, 1.1, 1.9, 3.0])


def test_derivatives_of_legendre_functions() -> None:
    tables = legendre_tables(DEGREE, DEGREE, THETA)
    assert tables.value.shape == (DEGREE + 1, DEGREE, THETA.size)
    h = 1e-3
    near = [legendre_functions(DEGREE, DEGREE, THETA + i * h) for i in (-3, -2, -1, 0, 1, 2, 3)]
    first = np.array([-1, 9, -45, 0, 45, -9, 1]) / (60 * h)
    second = np.array([2, -27, 270, -490, 270, -27, 2]) / (180 * h**2)
    assert_allclose(tables.slope, np.tensordot(first, near, 1), rtol=0, atol=1e-10)
    assert_allclose(tables.curvature, np.tensordot(second, near, 1), rtol=0, atol=1e-7)


def test_legendre_functions_are_orthonormal() -> None:
    nodes, weights = np.polynomial.legendre.leggauss(DEGREE + 1)
    table = legendre_functions(DEGREE, DEGREE - 1, np.arccos(nodes))
    for order, values in enumerate(table):
        product = 2 * np.pi * (values * weights) @ values.T
        unit = np.diag((np.arange(DEGREE) >= order).astype(float))
        assert_allclose(product, unit, rtol=0, atol=1e-14)


@pytest.mark.parametrize("m", [0, 1, 2, DEGREE - 1, DEGREE])
def test_members_are_those_of_the_basis(m: int) -> None:
    table = legendre_tables(DEGREE, m + 1, THETA).value
    members = cylindrical_members(table, m)
    basis = azimuthal_basis(DEGREE, m)
    assert members.shape[1] == member_count(DEGREE, m) == len(basis)
    phi = 0.7
    cosine, sine = np.cos(m * phi), np.sin(m * phi) if m else 1.0
    values = basis @ real_harmonics(DEGREE, THETA, np.full_like(THETA, phi)).T
    radial = np.cos(phi) * values[:, 0] + np.sin(phi) * values[:, 1]
    around = np.cos(phi) * values[:, 1] - np.sin(phi) * values[:, 0]
    expected = np.stack([radial, around, values[:, 2]])
    found = members * np.array([cosine, sine, cosine])[:, None, None]
    assert_allclose(found, expected, rtol=0, atol=1e-14)


@pytest.mark.parametrize("m", [0, 1, 3, DEGREE])
def test_members_are_orthonormal(m: int) -> None:
    nodes, weights = np.polynomial.legendre.leggauss(DEGREE + 1)
    table = legendre_tables(DEGREE, m + 1, np.arccos(nodes)).value
    members = cylindrical_members(table, m)
    product = azimuthal_weight(m) * np.einsum("cat,cbt,t->ab", members, members, weights)
    assert_allclose(product, np.eye(len(product)), rtol=0, atol=1e-14)


@pytest.mark.parametrize("order", range(DEGREE))
def test_harmonics_seen_from_another_pole(order: int) -> None:
    poles = (1e-3, 0.6, 1.5, 2.9)
    even, odd = meridian_rotation(DEGREE, order, poles)
    alpha, beta = np.array([0.2, 1.0, 2.2, 3.1]), np.array([0.3, -1.2, 2.5, 4.0])
    mu = np.arange(DEGREE)
    here = legendre_functions(DEGREE, DEGREE - 1, alpha)
    for pole, turned_even, turned_odd in zip(poles, even, odd, strict=True):
        # Along the pole, away from the north pole, and to the east.
        frame = np.array(
            [[np.sin(pole), 0, np.cos(pole)], [np.cos(pole), 0, -np.sin(pole)], [0, 1, 0]]
        )
        parts = np.stack(
            [np.cos(alpha), np.sin(alpha) * np.cos(beta), np.sin(alpha) * np.sin(beta)]
        )
        x, y, z = np.einsum("ac,ap->cp", frame, parts)
        there = legendre_functions(DEGREE, order, np.arccos(z))[order]
        phi = np.arctan2(y, x)
        cosines, sines = np.cos(np.outer(mu, beta)), np.sin(np.outer(mu, beta))
        found = np.einsum("nu,unp,up->np", turned_even, here, cosines)
        assert_allclose(found, there * np.cos(order * phi), rtol=0, atol=1e-13)
        found = np.einsum("nu,unp,up->np", turned_odd, here, sines)
        assert_allclose(found, there * np.sin(order * phi), rtol=0, atol=1e-13)
