"""Degree, mean points and displacements of shapes, as arrays of NumPy and of JAX."""

from collections.abc import Callable
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

import celltrain
import celltrain.runtime
from celltrain.harmonics import (
    degree_of,
    displaced,
    displaced_along,
    gauss_colatitudes,
    mean_points,
    real_harmonics,
)

DEGREE, CELLS = 5, 3
Convert = Callable[[np.ndarray], np.ndarray]
both = pytest.mark.parametrize("convert", [np.asarray, jnp.asarray])


def shapes() -> np.ndarray:
    return np.random.default_rng(2).normal(size=(CELLS, 3, DEGREE**2))


def grid() -> tuple[np.ndarray, np.ndarray]:
    """Harmonics at the points of a grid, and its weights over the whole solid angle."""
    theta, gauss = gauss_colatitudes(DEGREE)
    phi = np.arange(2 * DEGREE) * np.pi / DEGREE
    values = real_harmonics(DEGREE, np.repeat(theta, phi.size), np.tile(phi, theta.size))
    return values, np.repeat(gauss, phi.size) / (2.0 * phi.size)


@both
def test_the_degree_is_that_of_the_harmonics(convert: Convert) -> None:
    for degree in (1, 2, 17, 48):
        assert degree_of(convert(np.zeros((3, degree**2)))) == degree


def test_coefficients_of_no_degree() -> None:
    with pytest.raises(ValueError, match="24 coefficients"):
        degree_of(np.zeros((3, 24)))


@both
def test_mean_points_are_means_over_solid_angle(convert: Convert) -> None:
    values, weights = grid()
    expected = np.einsum("p,pk,cik->ci", weights, values, shapes())
    given = convert(shapes())
    assert_allclose(mean_points(given), expected, atol=1e-13)
    assert_allclose(mean_points(given[1]), expected[1], atol=1e-13)
    assert isinstance(mean_points(given), type(given))


@both
def test_a_displacement_moves_every_point(convert: Convert) -> None:
    values, _ = grid()
    by = np.random.default_rng(3).normal(size=(CELLS, 3))
    given = convert(shapes())
    moved = displaced(given, convert(by))
    assert isinstance(moved, type(given))
    change = np.einsum("pk,cik->cpi", values, np.asarray(moved) - shapes())
    assert_allclose(change, np.broadcast_to(by[:, None], change.shape), atol=1e-13)
    # One displacement for all, and one shape.
    assert_allclose(displaced(given, convert(by[0])) - given, np.asarray(moved - given)[[0, 0, 0]])
    assert_allclose(displaced(given[2], convert(by[2])), moved[2])
    # What was given stays as it was.
    assert_allclose(given, shapes(), rtol=0, atol=0)


@both
def test_displacements_along_the_tube(convert: Convert) -> None:
    given, distance = convert(shapes()), np.array([0.3, -2.0, 7.0])
    upward = np.array([0.0, 0.0, 1.0])
    expected = displaced(given, convert(distance[:, None] * upward))
    assert_allclose(displaced_along(given, convert(distance)), expected, rtol=0, atol=0)
    assert_allclose(displaced_along(given, 0.5), displaced(given, convert(0.5 * upward)))


def test_in_a_program_of_jax() -> None:
    given = jnp.asarray(shapes())
    compiled = jax.jit(lambda each, by: mean_points(displaced_along(each, by))[:, 2])
    expected = mean_points(shapes())[:, 2] + np.arange(CELLS)
    assert_allclose(compiled(given, jnp.arange(CELLS) * 1.0), expected, atol=1e-13)


def test_nothing_else_counts_coefficients_or_displaces() -> None:
    package = Path(celltrain.__file__).parent
    for path in package.rglob("*.py"):
        if path != package / "harmonics" / "shapes.py":
            text = path.read_text()
            for inline in ("isqrt", "sqrt(4.0 * math.pi)", "sqrt(4.0 * np.pi)"):
                assert inline not in text, (path, inline)
