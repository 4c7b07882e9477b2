"""Compiled loops compute what the formulas say, which give their derivatives."""

import math
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numba import njit
from numpy.testing import assert_allclose, assert_array_equal
from scipy.special import erfc

from celltrain.clock import compilation
from celltrain.compiled.nearest_search import (
    FUNCTIONS,
    _jet,
    arranged_shapes,
    search_factors,
)
from celltrain.compiled.pairs import near_parts
from celltrain.flow import own_surface_rule
from celltrain.flow.close import LevelledPairs, _force_formula, close_rule, force_velocity
from celltrain.flow.near import PATCH, NearPairs, _pair_sums_formula, block_sum, pair_sums
from celltrain.flow.own_surface import (
    _double_layer_formula,
    _own_formula,
    own_double_layer,
    own_velocity,
)
from celltrain.harmonics import real_harmonics
from celltrain.membrane import reference_coefficients
from celltrain.proximity.close_pairs import LeftOut
from celltrain.proximity.nearest import nearest_point_search, nearest_points
from celltrain.runtime import constant

XI, CUTOFF = 1.3, 1.6
# Five patches of sources, the last one with fewer.
CHUNKS, TARGETS, BLOCKS, SOURCES, IMAGES = 3, 5, 4, 5 * PATCH - 9, 1


def inputs() -> list[jax.Array]:
    """Targets, points, forces, stresslets and period."""
    random = np.random.default_rng(3)
    shapes = ((CHUNKS, TARGETS, 3), *((BLOCKS, SOURCES, parts) for parts in (3, 3, 6)))
    made = [random.normal(size=shape) for shape in shapes]
    # Most patches are out of the range of most targets.
    middles = 2.0 * random.normal(size=(BLOCKS, 5, 3))
    made[1] = 0.3 * made[1] + np.repeat(middles, PATCH, axis=1)[:, :SOURCES]
    return [*map(jnp.asarray, made), jnp.asarray(0.5)]


def near_pairs(*, left_out: bool) -> NearPairs:
    """A third of all pairs; of the cells' rows that have close targets, some are not used."""
    random = np.random.default_rng(4)
    images, cells, rows = 2 * IMAGES + 1, 2, 9
    near = jnp.asarray(random.random((images, CHUNKS, BLOCKS)) < 0.3)
    row_of = np.full(images * CHUNKS * cells, -1)
    row_of[random.permutation(row_of.size)[:rows]] = np.arange(rows)
    close = jnp.asarray(random.random((rows + 2, TARGETS)) < 0.6)
    some = LeftOut(jnp.asarray(row_of.reshape(images, CHUNKS, cells)), close)
    return NearPairs(near, jnp.asarray([0, 1, 0, 1]), some if left_out else None)


@njit
def _parts(square: float) -> tuple[float, float, float]:
    return near_parts(square, XI)


@pytest.mark.parametrize("square", [1e-8, 0.01, 0.5, 3.0, 12.0, 50.0])
def test_parts_of_the_near_kernel(square: float) -> None:
    screened, gauss, inverse = _parts(square)
    r = np.sqrt(square)
    # Relative to the free kernel, which is what errors are measured by.
    assert_allclose(screened * r, erfc(XI * r), rtol=0, atol=1e-12)
    assert_allclose(gauss, 2 * XI / np.sqrt(np.pi) * np.exp(-((XI * r) ** 2)), rtol=0, atol=1e-12)
    assert_allclose(inverse * square, 1.0, rtol=1e-14)


@pytest.mark.parametrize("left_out", [False, True])
@pytest.mark.parametrize("absent", [None, 2, 3])
def test_pairs(left_out: bool, absent: int | None) -> None:
    given = inputs()
    if absent is not None:
        given[absent] = None
    pairs = near_pairs(left_out=left_out)
    found = jax.jit(partial(pair_sums, XI, CUTOFF))(*given, pairs)
    expected = jax.jit(partial(_pair_sums_formula, XI, CUTOFF))(pairs, *given)
    assert np.abs(expected).max() > 0.1
    assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


def test_pairs_one_by_one() -> None:
    targets, points, forces, _, period = inputs()
    pairs = near_pairs(left_out=True)
    assert pairs.left_out is not None
    rows, close = map(np.asarray, (pairs.left_out.rows, pairs.left_out.close))
    expected = np.zeros((2 * IMAGES + 1, CHUNKS, TARGETS, 3))
    for image, chunk, block in np.argwhere(np.asarray(pairs.near)):
        row = rows[image, chunk, pairs.cells[block]]
        here = targets[chunk] - jnp.array([0.0, 0.0, 1.0]) * (image - IMAGES) * period
        part = np.array(block_sum(here, points[block], forces[block], XI, CUTOFF))
        if row >= 0:
            part[close[row]] = 0.0
        expected[image, chunk] += part
    found = pair_sums(XI, CUTOFF, targets, points, forces, None, period, pairs)
    assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


def test_derivative_of_the_pairs() -> None:
    given, pairs = inputs(), near_pairs(left_out=True)
    random = np.random.default_rng(5)
    moved = [jnp.asarray(random.normal(size=each.shape)) for each in given]

    def sums(step: float) -> jax.Array:
        return pair_sums(
            XI, CUTOFF, *(a + step * b for a, b in zip(given, moved, strict=True)), pairs
        )

    found = jax.jvp(sums, (0.0,), (1.0,))[1]
    step = 1e-5
    expected = (sums(step) - sums(-step)) / (2 * step)
    assert_allclose(found, expected, rtol=0, atol=1e-6 * np.abs(expected).max())


def test_what_is_no_number_stays_none() -> None:
    given, pairs = inputs(), near_pairs(left_out=False)
    given[0] = given[0].at[1, 2, 0].set(jnp.nan)
    found = np.asarray(pair_sums(XI, CUTOFF, *given, pairs))
    assert pairs.near[:, 1].any()
    assert np.isnan(found[:, 1, 2]).any()
    assert np.isfinite(np.delete(found, 1, axis=1)).all()


@pytest.mark.parametrize(("degree", "azimuthal", "cells"), [(3, 6, 4), (5, 7, 1), (8, 7, 4)])
def test_own_surface(degree: int, azimuthal: int, cells: int) -> None:
    random = np.random.default_rng(7)
    theta = np.array([0.3, 1.2, 2.9])
    rule = own_surface_rule(degree, theta, radial=5, azimuthal=azimuthal, parameter=XI)
    targets = jnp.asarray(random.normal(size=(cells, 3, 5, 3)))
    longitudes = jnp.asarray(random.uniform(-4.0, 4.0, 5))
    shapes, forces = (jnp.asarray(random.normal(size=(cells, 3, degree**2))) for _ in range(2))
    given = rule, targets, longitudes, shapes, forces
    found, expected = jax.jit(own_velocity)(*given), jax.jit(_own_formula)(*given)
    assert np.abs(expected).max() > 0.1
    assert_allclose(found, expected, rtol=0, atol=1e-11 * np.abs(expected).max())
    # What is no number stays none, and where it is.
    found = np.array(own_velocity(rule, targets.at[0, 1, 2].set(jnp.nan), *given[2:]))
    assert np.isnan(found[0, 1, 2]).all()
    found[0, 1, 2] = expected[0, 1, 2]
    assert_allclose(found, expected, rtol=0, atol=1e-11 * np.abs(expected).max())


@pytest.mark.parametrize(("degree", "azimuthal", "radial"), [(3, 7, 4), (5, 6, 5), (8, 6, 4)])
def test_own_double_layer(degree: int, azimuthal: int, radial: int) -> None:
    random = np.random.default_rng(8)
    theta = np.array([0.3, 1.2, 2.9])
    rule = own_surface_rule(degree, theta, radial=radial, azimuthal=azimuthal, parameter=XI)
    targets = jnp.asarray(random.normal(size=(4, 3, 9, 3)))
    longitudes = jnp.asarray(random.uniform(-4.0, 4.0, 9))
    shapes = jnp.asarray(random.normal(size=(4, 3, degree**2)))
    given = rule, targets, longitudes, shapes
    both = jax.jit(own_double_layer)(*given), jax.jit(_double_layer_formula)(*given)
    for found, expected in zip(*both, strict=True):
        assert found.shape == expected.shape
        assert np.abs(expected).max() > 0.1
        assert_allclose(found, expected, rtol=0, atol=1e-11 * np.abs(expected).max())


@pytest.mark.parametrize(("degree", "azimuthal", "radial"), [(3, 7, 4), (5, 6, 5), (8, 9, 6)])
@pytest.mark.parametrize("counts", [(0, 17, 0, 3, 16), (1, 0, 0, 0, 40), (0, 0, 0, 0, 0)])
def test_close_forces(degree: int, azimuthal: int, radial: int, counts: tuple[int, ...]) -> None:
    """Levels without pairs, with some and with whole chunks of them; others are not valid."""
    random = np.random.default_rng(10)
    rule = close_rule(degree, parameter=XI, farthest=16e-4, radial=radial, azimuthal=azimuthal)
    assert len(counts) == rule.levels.size
    valid, pairs = sum(counts), sum(counts) + 4
    order = random.permutation(pairs)
    theta = random.uniform(0.0, np.pi, pairs)
    theta[:3] = 0.0, np.pi, 1e-9
    levelled = LevelledPairs(
        cells=jnp.asarray(random.integers(0, 3, pairs)),
        poles=jnp.asarray(np.stack([theta, random.uniform(-4.0, 4.0, pairs)], axis=-1)),
        valid=jnp.asarray(np.isin(np.arange(pairs), order[:valid])),
        order=jnp.asarray(order),
        bounds=jnp.asarray(np.cumsum([0, *counts])),
    )
    points = random.normal(size=(pairs, 3))
    points[order[valid:]] = np.nan
    shapes, forces = (jnp.asarray(random.normal(size=(3, 3, degree**2))) for _ in range(2))
    given = rule, levelled, jnp.asarray(points), shapes, forces
    found, expected = jax.jit(force_velocity)(*given), jax.jit(_force_formula)(*given)
    assert (np.asarray(expected) != 0.0).all(axis=1).sum() == valid
    assert_allclose(found, expected, rtol=0, atol=1e-11 * np.abs(expected).max())


def test_derivatives_on_the_own_surface() -> None:
    random = np.random.default_rng(9)
    rule = own_surface_rule(3, np.array([0.4, 2.0]), radial=4, azimuthal=6, parameter=XI)
    longitudes = jnp.asarray([0.0, 1.0, 4.0])
    sizes = (2, 2, 3, 3), (2, 3, 9), (2, 3, 9)
    given, moved = ([jnp.asarray(random.normal(size=each)) for each in sizes] for _ in range(2))

    def both(step: float | jax.Array) -> tuple[jax.Array, ...]:
        targets, shapes, forces = (a + step * b for a, b in zip(given, moved, strict=True))
        velocity = own_velocity(rule, targets, longitudes, shapes, forces)
        return velocity, *own_double_layer(rule, targets, longitudes, shapes)

    # Several at once, as for a matrix.
    scaled = jax.jit(jax.vmap(lambda by: jax.jvp(both, (0.0,), (by,))[1]))(jnp.array([1.0, -2.0]))
    step = 1e-5
    differences = zip(both(step), both(-step), strict=True)
    for found, (above, below) in zip(scaled, differences, strict=True):
        expected = (above - below) / (2 * step)
        assert_allclose(found[0], expected, rtol=0, atol=1e-6 * np.abs(expected).max())
        assert_allclose(found[1], -2.0 * found[0], rtol=0, atol=1e-12 * np.abs(expected).max())


def test_tables_become_arrays_without_a_program() -> None:
    """Of a shape that nothing else has: what JAX makes by itself it compiles for each."""
    before = compilation.seconds()
    made = constant(np.ones((3, 11, 17)))
    assert compilation.seconds() == before
    assert isinstance(made, jax.Array)
    assert made.dtype == float
    jnp.asarray(np.ones((3, 11, 19)))
    assert compilation.seconds() > before


@pytest.mark.parametrize("degree", [6, 12])
def test_nearest_points_by_the_loop(degree: int) -> None:
    """Also from guesses at a pole; what is not valid is left alone."""
    random = np.random.default_rng(8)
    count = 150
    rest = reference_coefficients(degree, "biconcave")
    low = np.arange(degree**2) < 16
    shapes = rest + 0.05 * low * random.normal(size=(3, *rest.shape))
    theta, phi = np.arccos(random.uniform(-1, 1, count)), random.uniform(0, 6.3, count)
    theta[:3] = 0.0, np.pi, 1e-9
    cells, valid = np.arange(count) % 3, random.random(count) < 0.8
    feet = np.einsum("pk,pik->pi", real_harmonics(degree, theta, phi), shapes[cells])
    points = feet + random.uniform(-0.1, 0.1, feet.shape)
    guesses = np.stack([theta, phi], axis=-1)
    search = nearest_point_search(degree)
    points[0], valid[:3] = [0.0, 0.0, 1.0], True
    given = tuple(jnp.asarray(each) for each in (points, cells, shapes, guesses, valid))
    found = eqx.filter_jit(search.of_valid)(*given)
    ordered = (given[1], given[4], given[0], given[2], given[3])
    distance, stretch, converged = eqx.filter_jit(search._in_chunks)(*ordered).T[2:]
    assert_allclose(found.distance, distance, rtol=0, atol=1e-12)
    assert_allclose(found.stretch, stretch, rtol=0, atol=1e-6)
    assert np.isinf(np.asarray(found.distance)).sum() == (~valid).sum() > 0
    # Each pair ends by itself there, where here all of a chunk go on.
    assert (np.asarray(found.converged) >= np.asarray(converged)).all()
    # The same loop, called by Python.
    angles, signed = nearest_points(points[valid], cells[valid], shapes, guesses[valid])
    assert_array_equal(signed, found.distance[valid])
    assert_array_equal(angles, np.stack([found.theta, found.phi], axis=-1)[valid])


@njit
def _derivatives(theta: float, phi: float, shape: np.ndarray) -> np.ndarray:
    degree = round(math.sqrt(shape.shape[2]))
    functions, jet = np.zeros((FUNCTIONS, degree + 1, degree)), np.zeros((6, 3))
    factors, arranged = search_factors(degree), arranged_shapes(shape, degree)
    _jet(theta, phi, arranged[0], factors, functions, jet)
    return jet


def test_derivatives_of_a_surface_by_the_loop() -> None:
    """Beside those from the coefficients seen from the pole, also at both poles."""
    degree, random = 8, np.random.default_rng(9)
    shape = random.normal(size=(1, 3, degree**2))
    theta = np.array([0.0, 1e-9, 1e-4, 0.7, 2.0, np.pi])
    phi = random.uniform(0.0, 6.3, theta.size)
    search = nearest_point_search(degree)
    seen = search.rotation.seen_from_equator(
        jnp.repeat(jnp.asarray(shape), theta.size, axis=0), jnp.asarray(theta), jnp.asarray(phi)
    )
    expected = jnp.einsum("jk,pik->pji", search.jet, seen)
    for place, values in enumerate(np.asarray(expected)):
        jet = _derivatives(theta[place], phi[place], shape)
        assert_allclose(jet, values, rtol=0, atol=1e-11 * np.abs(values).max())
