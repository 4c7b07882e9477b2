"""Spherical harmonics, their grids, and the rule about a target."""

import math
from collections.abc import Callable

import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import sph_harm_y

from celltrain.harmonics import (
    about_pole,
    axisymmetric_basis,
    azimuthal_basis,
    coefficient_index,
    coefficients_of,
    cylindrical_members,
    degrees_and_orders,
    legendre_tables,
    member_count,
    polar_nodes,
    profile_of,
    project_meridian,
    real_harmonics,
)
from celltrain.harmonics.grid import sphere_grid
from celltrain.harmonics.longitude import shift_longitude, unshift_longitude
from celltrain.harmonics.polar import polar_rotation, polar_tables
from celltrain.harmonics.tables import harmonic_tables

DEGREE = 8


def points(count: int = 40) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(0)
    return np.arccos(random.uniform(-0.99, 0.99, count)), random.uniform(0, 2 * np.pi, count)


def test_coefficients_are_ordered_by_degree_then_order() -> None:
    n, m = degrees_and_orders(DEGREE)
    assert n.size == DEGREE**2
    places = [coefficient_index(*pair) for pair in zip(n.tolist(), m.tolist(), strict=True)]
    assert places == list(range(DEGREE**2))


def test_values_are_those_of_the_complex_harmonics() -> None:
    theta, phi = points()
    for (n, m), found in zip(
        np.transpose(degrees_and_orders(DEGREE)), real_harmonics(DEGREE, theta, phi).T, strict=True
    ):
        # Without the Condon-Shortley sign.
        value = (-1.0) ** m * sph_harm_y(n, abs(m), theta, phi)
        scale = 1 if m == 0 else math.sqrt(2)
        assert_allclose(found, scale * (value.imag if m < 0 else value.real), rtol=0, atol=1e-13)


def test_grid_is_orthonormal_up_to_its_order() -> None:
    # Products have degrees up to 2 * 7 = 14, below 2 * rings.
    grid = sphere_grid(DEGREE, DEGREE)
    assert_allclose(grid.projection @ grid.values, np.eye(DEGREE**2), rtol=0, atol=1e-13)
    coarse = sphere_grid(DEGREE, DEGREE - 1)
    assert np.abs(coarse.projection @ coarse.values - np.eye(DEGREE**2)).max() > 0.1


def test_projection_recovers_coefficients() -> None:
    grid = sphere_grid(DEGREE, DEGREE + 3)
    theta, phi = grid.points()
    coefficients = np.random.default_rng(1).normal(size=DEGREE**2)
    values = real_harmonics(DEGREE, theta, phi) @ coefficients
    assert_allclose(grid.projection @ values, coefficients, rtol=0, atol=1e-13)


@pytest.mark.parametrize(
    ("derivative", "of", "along"),
    [
        ("d_theta", "value", 0),
        ("d_phi", "value", 1),
        ("d_theta_theta", "d_theta", 0),
        ("d_theta_phi", "d_theta", 1),
        ("d_phi_phi", "d_phi", 1),
    ],
)
def test_derivatives_are_limits_of_differences(derivative: str, of: str, along: int) -> None:
    at = np.stack(points())
    exact = np.asarray(getattr(harmonic_tables(DEGREE, *at), derivative))

    def error(step: float) -> float:
        move = step * np.eye(2)[along][:, None]
        ahead, behind = (
            np.asarray(getattr(harmonic_tables(DEGREE, *(at + sign * move)), of))
            for sign in (1, -1)
        )
        return float(np.abs((ahead - behind) / (2 * step) - exact).max())

    assert np.log10(error(1e-2) / error(1e-3)) == pytest.approx(2, abs=0.05)
    assert error(1e-4) < 1e-5


def test_shifted_coefficients_are_those_of_the_turned_function() -> None:
    theta, phi = points()
    coefficients = np.random.default_rng(2).normal(size=(3, DEGREE**2))
    angles = np.array([0.3, -1.7])
    shifted = shift_longitude(jnp.asarray(coefficients), jnp.asarray(angles))
    for angle, each in zip(angles, shifted, strict=True):
        expected = real_harmonics(DEGREE, theta, phi + angle) @ coefficients.T
        assert_allclose(real_harmonics(DEGREE, theta, phi) @ each.T, expected, rtol=0, atol=1e-12)


def direction(theta: np.ndarray, phi: np.ndarray) -> np.ndarray:
    return np.stack(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1
    )


@pytest.mark.parametrize("theta", [0.1, 1.3, 3.0])
@pytest.mark.parametrize(
    ("integrand", "integral"),
    [
        # int exp(a.x) = 4 pi sinh|a|/|a|.
        (lambda x, pole: np.exp(x @ [1.0, 2.0, 2.0]), 4 * math.pi * math.sinh(3) / 3),
        # The chord to the pole is 2 sin(alpha/2): int 1/chord = 4 pi.
        (lambda x, pole: 1 / np.linalg.norm(x - pole, axis=-1), 4 * math.pi),
        # int x/chord = (4 pi/3) pole.
        (lambda x, pole: x @ pole / np.linalg.norm(x - pole, axis=-1), 4 * math.pi / 3),
    ],
    ids=["smooth", "singular", "dipole"],
)
def test_rule_about_a_target_integrates_a_singularity(
    theta: float, integrand: Callable[..., np.ndarray], integral: float
) -> None:
    alpha, beta, weights = polar_nodes(20, 28)
    node_theta, node_phi = about_pole(theta, *np.meshgrid(alpha, beta, indexing="ij"))
    pole = direction(np.array(theta), np.array(0.0))
    found = np.sum(weights * integrand(direction(node_theta, node_phi), pole))
    assert_allclose(found, integral, rtol=1e-12)


def test_rule_about_a_target_is_symmetric() -> None:
    alpha, beta, weights = polar_nodes(6, 10)
    theta, phi = (
        each.ravel() for each in about_pole(0.8, *np.meshgrid(alpha, beta, indexing="ij"))
    )
    mirrored = sorted(
        zip(theta.round(12), (-phi).round(12), weights.ravel().round(12), strict=True)
    )
    assert mirrored == sorted(
        zip(theta.round(12), phi.round(12), weights.ravel().round(12), strict=True)
    )


@pytest.mark.parametrize("theta", [0.2, 1.4])
def test_polar_frame(theta: float) -> None:
    degree = 7
    random = np.random.default_rng(1)
    coefficients = random.normal(size=(2, degree * degree))
    rotation = polar_rotation(degree, theta)
    assert_allclose(rotation @ rotation.T, np.eye(degree * degree), rtol=0, atol=1e-13)
    alpha, beta, _ = polar_nodes(9, 14)
    tables = polar_tables(degree, alpha, beta)
    turned = jnp.asarray(coefficients @ rotation.T)

    def exact(alpha: np.ndarray, beta: np.ndarray) -> np.ndarray:
        points = about_pole(theta, *np.broadcast_arrays(alpha[:, None], beta))
        harmonics = real_harmonics(degree, *(each.ravel() for each in points))
        return (coefficients @ harmonics.T).reshape(2, alpha.size, beta.size)

    values, down, across = tables.with_tangents(turned)
    assert_allclose(values, exact(alpha, beta), rtol=0, atol=1e-12)
    assert_allclose(tables.values(turned), values, rtol=0, atol=1e-13)
    step = 1e-4
    slope = (exact(alpha + step, beta) - exact(alpha - step, beta)) / (2 * step)
    assert_allclose(down, slope, rtol=0, atol=1e-5)
    slope = (exact(alpha, beta + step) - exact(alpha, beta - step)) / (2 * step)
    assert_allclose(across, slope / np.sin(alpha)[:, None], rtol=0, atol=1e-5)
    # The moments are the transpose of the values.
    numbers = random.normal(size=(2, alpha.size, beta.size))
    assert_allclose(
        np.sum(np.asarray(tables.moments(jnp.asarray(numbers))) * turned),
        np.sum(numbers * values),
        rtol=1e-12,
    )


def test_unshift_is_the_transpose_of_shift() -> None:
    random = np.random.default_rng(2)
    coefficients, angles = random.normal(size=(3, 25)), jnp.array([0.0, 0.4, 2.0])
    functionals = random.normal(size=(3, 3, 25))
    shifted = shift_longitude(jnp.asarray(coefficients), angles)
    back = unshift_longitude(jnp.asarray(np.swapaxes(functionals, 0, 1)), angles)
    assert_allclose(
        np.einsum("cak,ck->", back, coefficients),
        np.einsum("ack,ack->", functionals, shifted),
        rtol=1e-12,
    )


@pytest.mark.parametrize("m", [0, 1, 2, DEGREE - 1, DEGREE])
def test_members_on_the_meridian_are_those_of_the_basis(m: int) -> None:
    theta, _ = points(7)
    phi = 0.4
    basis = azimuthal_basis(DEGREE, m)
    assert len(basis) == member_count(DEGREE, m)
    fields = basis @ real_harmonics(DEGREE, theta, np.full_like(theta, phi)).T
    along, around, axial = cylindrical_members(legendre_tables(DEGREE, m + 1, theta).value, m)
    radial = np.cos(phi) * fields[:, 0] + np.sin(phi) * fields[:, 1]
    turning = np.cos(phi) * fields[:, 1] - np.sin(phi) * fields[:, 0]
    sine = np.sin(m * phi) if m else 1.0
    assert_allclose(radial, along * np.cos(m * phi), rtol=0, atol=1e-13)
    assert_allclose(turning, around * sine, rtol=0, atol=1e-13)
    assert_allclose(fields[:, 2], axial * np.cos(m * phi), rtol=0, atol=1e-13)


def test_profiles_are_axisymmetric_shapes() -> None:
    profile = np.random.default_rng(3).normal(size=(2, DEGREE))
    profile[1, 0] = 0.0
    shape = coefficients_of(profile)
    assert_allclose(profile_of(shape), profile, rtol=0, atol=1e-15)
    amounts = np.concatenate([profile[0], profile[1, 1:]])
    assert_allclose(np.tensordot(amounts, axisymmetric_basis(DEGREE), 1), shape, atol=1e-15)

    def meridian(theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        x, _, z = shape @ real_harmonics(DEGREE, theta, np.zeros_like(theta)).T
        return x, z

    assert_allclose(project_meridian(DEGREE, meridian, DEGREE + 2), profile, rtol=0, atol=1e-13)
