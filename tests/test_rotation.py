"""Harmonics seen from another pole: the same function, for any degree and any pole."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain.harmonics import real_harmonics
from celltrain.harmonics.longitude import shift_longitude, turn_longitude
from celltrain.harmonics.rotation import pole_rotation

PAIRS = 12


def given_place(theta: float, phi: float, alpha: float, beta: float) -> tuple[float, float]:
    """Where R_z(phi) R_y(theta) brings the point (alpha, beta)."""
    about_y = np.array(
        [[np.cos(theta), 0, np.sin(theta)], [0, 1, 0], [-np.sin(theta), 0, np.cos(theta)]]
    )
    about_z = np.array([[np.cos(phi), -np.sin(phi), 0], [np.sin(phi), np.cos(phi), 0], [0, 0, 1]])
    point = [np.sin(alpha) * np.cos(beta), np.sin(alpha) * np.sin(beta), np.cos(alpha)]
    x, y, z = about_z @ about_y @ point
    return np.arctan2(np.hypot(x, y), z), np.arctan2(y, x)


def poles(random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Random poles, among them both of the given frame's."""
    theta = np.arccos(random.uniform(-1, 1, PAIRS))
    theta[:2] = 0.0, np.pi
    return theta, random.uniform(-7, 7, PAIRS)


@pytest.mark.parametrize("degree", [1, 2, 7, 16])
def test_values_are_those_of_the_same_point(degree: int) -> None:
    random = np.random.default_rng(degree)
    theta, phi = poles(random)
    alpha, beta = np.arccos(random.uniform(-1, 1, PAIRS)), random.uniform(0, 7, PAIRS)
    functions = random.normal(size=(PAIRS, 2, degree * degree))
    turn = jax.jit(lambda rotation, *arguments: rotation.to_pole(*arguments))
    arguments = map(jnp.asarray, (functions, theta, phi))
    turned = turn(pole_rotation(degree), *arguments)
    there = np.array([given_place(*each) for each in zip(theta, phi, alpha, beta, strict=True)])
    assert_allclose(
        np.einsum("pck,pk->pc", turned, real_harmonics(degree, alpha, beta)),
        np.einsum("pck,pk->pc", functions, real_harmonics(degree, *there.T)),
        rtol=0,
        atol=1e-12 * degree,
    )


def test_inverse_is_the_transpose() -> None:
    degree = 9
    random = np.random.default_rng(0)
    theta, phi = map(jnp.asarray, poles(random))
    rotation = pole_rotation(degree)
    functions, others = jnp.asarray(random.normal(size=(2, PAIRS, 3, degree * degree)))
    turned = rotation.to_pole(functions, theta, phi)
    assert_allclose(rotation.from_pole(turned, theta, phi), functions, rtol=0, atol=1e-12)
    back = rotation.from_pole(others, theta, phi)
    assert_allclose(np.sum(turned * others), np.sum(functions * back), rtol=1e-12)


def test_degrees_do_not_mix() -> None:
    degree = 8
    quarter = np.asarray(pole_rotation(degree).quarter)
    n = np.repeat(np.arange(degree), 2 * np.arange(degree) + 1)
    assert not quarter[n[:, None] != n].any()
    assert_allclose(quarter @ quarter.T, np.eye(degree * degree), rtol=0, atol=1e-13)


def test_longitudes_are_turned_pair_by_pair() -> None:
    degree = 5
    random = np.random.default_rng(1)
    functions = jnp.asarray(random.normal(size=(4, 2, degree * degree)))
    angles = jnp.asarray(random.uniform(-4, 4, 4))
    expected = [shift_longitude(functions[i], angles[i : i + 1])[0] for i in range(4)]
    assert_allclose(turn_longitude(functions, angles), jnp.stack(expected), rtol=0, atol=1e-14)
