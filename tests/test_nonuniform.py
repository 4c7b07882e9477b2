"""Transforms between points and modes, with compiled loops and without, against sums by terms."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array
from numpy.testing import assert_allclose

from celltrain.compiled import dispatch
from celltrain.flow import nonuniform, spreading
from celltrain.flow.nonuniform import (
    Largest,
    modes_to_points,
    numbers_of_modes,
    points_to_modes,
)
from celltrain.flow.spreading import (
    grid_places,
    interpolate,
    kernel_transform,
    kernel_width,
    spread,
)
from celltrain.flow.transform import Transform
from celltrain.flow.wall import tube_wall

#: In a plane and in a box, some with few modes beside the kernel's width.
LARGEST = ((5, 7), (1, 60), (4, 6, 3), (2, 2, 40))
POINTS, FIELDS = 60, 3
TOLERANCES = (1e-3, 1e-6, 1e-9, 1e-12)


@pytest.fixture(params=["compiled", "plain"])
def way(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Both ways of the sums; functions are traced anew for each."""
    if request.param == "plain":
        monkeypatch.setattr(dispatch, "LOOPS_SERVE", False)
    return str(request.param)


def angles(axes: int) -> np.ndarray:
    """Points [point, axis], some on grid points, at the ends, and turns away."""
    found = np.random.default_rng(1).uniform(-np.pi, np.pi, (POINTS, axes))
    found[:4] = np.array([-np.pi, 0.0, np.pi, 2.0 * np.pi])[:, None]
    found[4:9] += 2.0 * np.pi * np.arange(-2, 3)[:, None]
    return found


def resolved(largest: Largest, tolerance: float) -> np.ndarray:
    """Factors of the modes that leave the tolerance at the largest along each axis."""
    parts = (
        np.exp(np.log(tolerance) * (numbers / most) ** 2)
        for numbers, most in zip(numbers_of_modes(largest), largest, strict=True)
    )
    return np.prod(np.broadcast_arrays(*parts), axis=0)


def waves(largest: Largest) -> np.ndarray:
    """The factors exp(i k . x) [point, *number]."""
    found = np.ones((POINTS, *(1,) * len(largest)))
    for numbers, along in zip(numbers_of_modes(largest), angles(len(largest)).T, strict=True):
        found = found * np.exp(1j * along.reshape(-1, *(1,) * len(largest)) * numbers)
    return found


def some_modes(largest: Largest, tolerance: float) -> np.ndarray:
    draw = np.random.default_rng(2)
    factors = resolved(largest, tolerance)
    parts = draw.normal(size=(2, FIELDS, *factors.shape))
    found = (parts[0] + 1j * parts[1]) * factors
    # Of real fields.
    across = tuple(range(1, len(largest)))
    found[..., 0] += np.conj(np.flip(found[..., 0], across))
    return found


def some_values() -> np.ndarray:
    return np.random.default_rng(3).normal(size=(POINTS, FIELDS))


def sum_of(modes: np.ndarray, factors: np.ndarray) -> np.ndarray:
    """Fields [point, field] by terms; modes that are left out are conjugates."""
    twice = np.where(np.arange(modes.shape[-1]), 2.0, 1.0)
    flat = (modes * twice).reshape(FIELDS, -1)
    found: np.ndarray = (factors.reshape(POINTS, -1) @ flat.T).real
    return found


@pytest.mark.parametrize("tolerance", TOLERANCES)
@pytest.mark.parametrize("largest", LARGEST)
@pytest.mark.usefixtures("way")
def test_points_to_modes(largest: Largest, tolerance: float) -> None:
    factors = resolved(largest, tolerance)
    exact = np.einsum("sf,s...->f...", some_values(), waves(largest).conj())
    found = points_to_modes(
        largest, jnp.asarray(some_values()), jnp.asarray(angles(len(largest))), tolerance
    )
    assert np.abs((found - exact) * factors).max() < tolerance * np.abs(exact).max()


@pytest.mark.parametrize("tolerance", TOLERANCES)
@pytest.mark.parametrize("largest", LARGEST)
@pytest.mark.usefixtures("way")
def test_modes_to_points(largest: Largest, tolerance: float) -> None:
    modes = some_modes(largest, tolerance)
    exact = sum_of(modes, waves(largest))
    found = modes_to_points(jnp.asarray(modes), jnp.asarray(angles(len(largest))), tolerance)
    assert np.abs(found - exact).max() < tolerance * np.abs(exact).max()


@pytest.mark.parametrize("largest", LARGEST)
def test_derivatives_are_sums_of_derivatives(largest: Largest) -> None:
    tolerance, axes = 1e-9, len(largest)
    where, factors = jnp.asarray(angles(axes)), waves(largest)
    draw = np.random.default_rng(4)
    moved = draw.normal(size=(POINTS, axes))
    values, d_values = some_values(), draw.normal(size=(POINTS, FIELDS))
    modes, d_modes = some_modes(largest, tolerance), some_modes(largest, tolerance)[::-1]
    along = sum(
        each.reshape(-1, *(1,) * axes) * numbers
        for each, numbers in zip(moved.T, numbers_of_modes(largest), strict=True)
    )

    forth = partial(points_to_modes, largest, tolerance=tolerance)
    _, change = jax.jvp(
        lambda values, where: forth(values, where),
        (jnp.asarray(values), where),
        (jnp.asarray(d_values), jnp.asarray(moved)),
    )
    exact = np.einsum("sf,s...->f...", d_values, factors.conj())
    exact = exact - 1j * np.einsum("sf,s...->f...", values, along * factors.conj())
    error = np.abs((change - exact) * resolved(largest, tolerance)).max()
    assert error < tolerance * np.abs(exact).max()

    _, change = jax.jvp(
        lambda modes, where: modes_to_points(modes, where, tolerance),
        (jnp.asarray(modes), where),
        (jnp.asarray(d_modes), jnp.asarray(moved)),
    )
    exact = sum_of(d_modes, factors) + sum_of(modes, 1j * along * factors)
    assert np.abs(change - exact).max() < tolerance * np.abs(exact).max()


@pytest.mark.parametrize(("most", "tolerance"), [(17, 1e-4), (16, 1e-8)])
@pytest.mark.usefixtures("way")
def test_points_at_the_kernels_ends_belong_to_them_in_programs(most: int, tolerance: float) -> None:
    """However a program rounds where they are: the first grid point covered is exactly there."""
    largest = (most, most)
    sizes, width = nonuniform._sizes(largest, tolerance), kernel_width(tolerance)
    steps = np.arange(POINTS)[:, None] * np.array([1, 7]) + 0.5 * (width % 2)
    where = jnp.asarray(2.0 * np.pi * steps / np.array(sizes))
    values, modes = jnp.asarray(some_values()), jnp.asarray(some_modes(largest, tolerance))
    forth = partial(points_to_modes, largest, tolerance=tolerance)
    back = partial(modes_to_points, tolerance=tolerance)
    for function, given in ((forth, values), (back, modes)):
        expected = function(given, where)
        found = jax.jit(partial(function))(given, where)
        # The kernel ends there with a step.
        assert_allclose(found, expected, rtol=0, atol=tolerance * np.abs(expected).max())


@pytest.mark.parametrize(
    "sizes", [(15, 24), (16, 15, 14), (14, 14, 75), (14, 14, 2400), (3, 5), (2, 4, 3)]
)
def test_both_ways_are_the_same_sums(
    sizes: tuple[int, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """On grids of one slab, of several, of many, and of fewer points than the kernel covers."""
    places, width = grid_places(jnp.asarray(angles(len(sizes))), sizes), 7
    values = jnp.asarray(some_values())
    grid = spread(values, places, sizes, width)
    found = interpolate(grid, places, width)
    with monkeypatch.context() as patch:
        patch.setattr(dispatch, "LOOPS_SERVE", False)
        assert_allclose(spread(values, places, sizes, width), grid, rtol=0, atol=1e-13)
        assert_allclose(interpolate(grid, places, width), found, rtol=1e-12, atol=1e-13)
    # One is the other's transpose.
    other = jnp.asarray(np.random.default_rng(5).normal(size=grid.shape))
    back = interpolate(other, places, width)
    assert_allclose(jnp.vdot(grid, other), jnp.vdot(values, back), rtol=1e-12)


@pytest.mark.usefixtures("way")
def test_no_points_give_nothing() -> None:
    none, sizes = jnp.zeros((0, 3)), (14, 14, 14)
    assert not np.any(spread(none, none, sizes, 7))
    assert interpolate(jnp.ones((2, *sizes)), none, 7).shape == (0, 2)


def test_batches_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Points that do not fill the last batch, and a batch for each point."""
    sizes, width = (14, 15, 16), 7
    places = grid_places(jnp.asarray(angles(3)), sizes)
    values = jnp.asarray(some_values())

    def both() -> tuple[Array, Array]:
        grid = spreading.plain_spread(values, places, sizes, width)
        return grid, spreading.plain_interpolate(grid, places, width)

    whole = both()
    for most in (1, 7 * FIELDS * width**3):
        monkeypatch.setattr(spreading, "MOST_VALUES", most)
        for found, expected in zip(both(), whole, strict=True):
            assert_allclose(found, expected, rtol=0, atol=1e-12)


def test_batches_of_fields_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """All at once, in twos of which the last has one, and one by one."""
    largest, tolerance = LARGEST[2], 1e-6
    where = jnp.asarray(angles(3))
    values, modes = jnp.asarray(some_values()), jnp.asarray(some_modes(largest, tolerance))

    def both() -> tuple[Array, Array]:
        found = points_to_modes(largest, values, where, tolerance)
        return found, modes_to_points(modes, where, tolerance)

    whole = both()
    monkeypatch.setattr(nonuniform, "MOST_GRID_VALUES", 1)
    for least in (2, 1):
        monkeypatch.setattr(nonuniform, "LEAST_FIELDS", least)
        for found, expected in zip(both(), whole, strict=True):
            assert_allclose(found, expected, rtol=0, atol=1e-13 * np.abs(expected).max())


@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_the_kernel_is_the_one_for_resolved_fields(
    tolerance: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What waves beyond the grid's are taken for stays below half of the tolerance.

    Other shapes of the kernel are at most by a third better.
    """
    width, parts = kernel_width(tolerance), np.linspace(0.0, 1.0, 41)
    waves = 0.5 * parts / nonuniform.UPSAMPLING

    def error(steepness: float) -> float:
        monkeypatch.setattr(spreading, "STEEPNESS", steepness)
        images = [np.abs(kernel_transform(waves + n, width)) for n in (-2, -1, 1, 2)]
        wrong = sum(images) / np.abs(kernel_transform(waves, width))
        return float((np.exp(np.log(tolerance) * parts**2) * wrong).max())

    chosen = error(spreading.STEEPNESS)
    assert chosen < 0.5 * tolerance
    assert min(map(error, np.arange(1.8, 2.8, 0.05))) > chosen / 1.5


@pytest.mark.parametrize("width", [4, 7, 10, 13, 16])
def test_polynomials_are_the_kernel(width: int) -> None:
    """As near as what it is cut off at its ends, or as rounding."""
    offset = np.linspace(0.0, 1.0, 201)[:, None]
    found = np.zeros((len(offset), width))
    for term in spreading.kernel_terms(width):
        found = found * offset + term
    t = 2.0 / width * (offset + np.arange(width)) - 1.0
    beta = spreading.STEEPNESS * width
    exact = np.exp(beta * (np.sqrt(np.maximum(1.0 - t**2, 0.0)) - 1.0))
    assert np.abs(found - exact).max() < max(np.exp(-beta), 1e-14)


@pytest.mark.usefixtures("way")
def test_what_is_no_number_stays_on_the_grid() -> None:
    """A point that is nowhere makes no numbers of what it reaches, and of nothing else."""
    sizes, width = (14, 14, 75), 7
    where = angles(3)
    where[0] = np.nan
    places = grid_places(jnp.asarray(where), sizes)
    grid = np.asarray(spread(jnp.ones((POINTS, 1)), places, sizes, width))
    assert np.isnan(grid).sum() == width**3
    for each in (np.nan, np.inf, -np.inf, 1e300):
        alone = grid_places(jnp.full((1, 3), each), sizes)
        found = interpolate(jnp.ones((1, *sizes)), alone, width)
        assert np.isnan(found).all() == (not np.isfinite(each))


def test_the_flow_is_the_same_without_loops(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also its derivatives, as the exact dynamics need them."""
    draw = np.random.default_rng(3)
    points = jnp.asarray(draw.uniform(-1.0, 1.0, (POINTS, 3)))
    strengths = jnp.asarray(draw.normal(size=(POINTS, 3)))
    transform = Transform((3, 3, 4), 1e-10, jnp.array([4.0, 4.0, 5.0]))
    wall = tube_wall(2.0, 5.0, wall_gap=0.8, tolerance=1e-4)
    boundary = jnp.asarray(draw.normal(size=(wall.rings, wall.azimuths, 3)))

    def there_and_back(points: Array) -> Array:
        return transform.synthesise(points, transform.analyse(points, strengths))

    def along_wall(points: Array) -> Array:
        return wall.velocity(points, wall.regular_flow(boundary))

    def all_of_it() -> list[Array]:
        found: list[Array] = []
        for flow in (there_and_back, along_wall):
            found += jax.jvp(flow, (points,), (strengths,))
        return found

    usual = all_of_it()
    monkeypatch.setattr(dispatch, "LOOPS_SERVE", False)
    for found, expected in zip(all_of_it(), usual, strict=True):
        assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
        assert not np.array_equal(found, expected)
