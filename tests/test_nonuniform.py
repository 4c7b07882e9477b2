"""Transforms between points and modes, with FINUFFT and without, against sums term by term."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array
from numpy.testing import assert_allclose

from celltrain.flow import nonuniform
from celltrain.flow.nonuniform import (
    modes_to_points,
    plain_modes_to_points,
    plain_points_to_modes,
    points_to_modes,
)
from celltrain.flow.transform import Transform
from celltrain.flow.wall import tube_wall

#: Odd and even numbers of modes, and few of them beside the kernel's width.
SHAPE = (9, 12, 5)
POINTS = 60
TOLERANCES = (1e-4, 1e-8, 1e-12)


def angles() -> tuple[Array, Array, Array]:
    x, y, z = np.random.default_rng(1).uniform(-np.pi, np.pi, (3, POINTS))
    x[0], y[0], z[0] = -np.pi, 0.0, np.pi  # on grid points, and at the ends
    return jnp.asarray(x), jnp.asarray(y), jnp.asarray(z)


def numbers(*shape: int) -> np.ndarray:
    draw = np.random.default_rng(2)
    return draw.normal(size=shape) + 1j * draw.normal(size=shape)


def waves(sign: int) -> np.ndarray:
    """The factors exp(sign i k . x) [x, y, z, point]."""
    along = [
        np.exp(sign * 1j * np.outer(np.arange(count) - count // 2, each))
        for count, each in zip(SHAPE, angles(), strict=True)
    ]
    return np.einsum("xs,ys,zs->xyzs", *along)


def relative(found: Array, exact: np.ndarray) -> float:
    return float(np.linalg.norm(np.asarray(found) - exact) / np.linalg.norm(exact))


@pytest.mark.parametrize("tolerance", TOLERANCES)
@pytest.mark.parametrize("transformed", [points_to_modes, plain_points_to_modes])
def test_points_to_modes(transformed: Callable[..., Array], tolerance: float) -> None:
    values = numbers(2, POINTS)
    exact = np.einsum("as,xyzs->axyz", values, waves(-1))
    found = transformed(SHAPE, jnp.asarray(values), angles(), tolerance)
    assert relative(found, exact) < tolerance


@pytest.mark.parametrize("tolerance", TOLERANCES)
@pytest.mark.parametrize("transformed", [modes_to_points, plain_modes_to_points])
def test_modes_to_points(transformed: Callable[..., Array], tolerance: float) -> None:
    modes = numbers(2, *SHAPE)
    exact = np.einsum("axyz,xyzs->as", modes, waves(1))
    assert relative(transformed(jnp.asarray(modes), angles(), tolerance), exact) < tolerance


def test_batches_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Points that do not fill the last batch, and a batch for each point."""
    values, modes = jnp.asarray(numbers(2, POINTS)), jnp.asarray(numbers(2, *SHAPE))

    def both() -> tuple[Array, Array]:
        return (
            plain_points_to_modes(SHAPE, values, angles(), 1e-6),
            plain_modes_to_points(modes, angles(), 1e-6),
        )

    whole = both()
    for most in (1, 7 * 2 * 8**3):
        monkeypatch.setattr(nonuniform, "MOST_VALUES", most)
        for found, expected in zip(both(), whole, strict=True):
            assert_allclose(found, expected, rtol=0, atol=1e-12)


def test_the_flow_is_the_same_where_finufft_was_not_built(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also its derivatives, as the exact dynamics need them."""
    draw = np.random.default_rng(3)
    points = jnp.asarray(draw.uniform(-1.0, 1.0, (POINTS, 3)))
    strengths = jnp.asarray(draw.normal(size=(POINTS, 3)))
    transform = Transform((7, 7, 9), 1e-10, jnp.array([4.0, 4.0, 5.0]))
    wall = tube_wall(2.0, 5.0, wall_gap=0.8, tolerance=1e-4)
    boundary = jnp.asarray(draw.normal(size=(wall.rings, wall.azimuths, 3)))

    def there_and_back(points: Array) -> Array:
        return transform.synthesise(points, transform.analyse(points, strengths))

    def along_wall(points: Array) -> Array:
        return wall.velocity(points, wall.regular_flow(boundary))

    def all_of_it() -> list[Array]:
        found = []
        for flow in (there_and_back, along_wall):
            found += jax.jvp(flow, (points,), (strengths,))
        return found

    usual = all_of_it()
    monkeypatch.setattr(nonuniform, "BUILT", ())
    for found, expected, tolerance in zip(
        all_of_it(), usual, (1e-9, 1e-9, 1e-3, 1e-3), strict=True
    ):
        assert relative(found, np.asarray(expected)) < tolerance
        assert not np.array_equal(found, expected)
