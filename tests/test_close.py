"""Flow close to a surface: exact solutions, identities, other rules; nearest points.

In free space (xi = 0) the sphere has solutions in solid harmonics for any density, and the double
layer of a rigid motion is that motion inside, with its sign changed, and nothing outside.
"""

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain.flow.close import CloseRule, close_rule, graded_nodes
from celltrain.flow.near import block_sum, stresslet_block_sum
from celltrain.harmonics import UNIT_DISPLACEMENT, degree_of, degrees_and_orders, real_harmonics
from celltrain.harmonics.grid import sphere_grid
from celltrain.harmonics.tables import harmonic_tables
from celltrain.membrane import reference_coefficients
from celltrain.proximity.nearest import nearest_point_search

DEGREE = 6
POINTS = 24
FREE, SCREENED = 0.0, 1.3
DISTANCES = np.repeat([0.5, 0.1, 0.02, 0.005], POINTS // 4)
Velocity = Callable[..., np.ndarray]


@pytest.fixture(scope="module")
def velocity() -> Velocity:
    """Velocity at points [point, 3], each paired with cell 0 from a poor guess."""

    @jax.jit
    def compiled(rule, points, guesses, shapes, forces, densities):
        cells = jnp.zeros(len(points), dtype=int)
        valid = jnp.ones(len(points), dtype=bool)
        return rule.velocity(points, cells, guesses, valid, shapes, forces, densities)

    def found(rule, points, places, shape, force=None, density=None) -> np.ndarray:
        guesses = jnp.asarray(places + np.array([0.07, -0.06]))
        given = (None if each is None else jnp.asarray(each)[None] for each in (force, density))
        return np.asarray(compiled(rule, jnp.asarray(points), guesses, shape[None], *given))

    return found


@pytest.fixture(scope="module")
def free_rule() -> CloseRule:
    return close_rule(DEGREE, parameter=FREE, farthest=0.5, radial=56, azimuthal=56)


@pytest.fixture(scope="module")
def biconcave() -> jax.Array:
    return jnp.asarray(reference_coefficients(DEGREE, "biconcave"))


@pytest.fixture(scope="module")
def sphere() -> jax.Array:
    return jnp.asarray(reference_coefficients(DEGREE, "sphere"))


def places(seed: int, count: int = POINTS) -> np.ndarray:
    """Random points (theta, phi) of the parameter sphere."""
    random = np.random.default_rng(seed)
    return np.stack(
        [np.arccos(random.uniform(-0.98, 0.98, count)), random.uniform(0, 2 * np.pi, count)],
        axis=-1,
    )


def surface(shape: jax.Array, where: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points, unit normals and normals n dS/dOmega of a shape."""
    tables = harmonic_tables(degree_of(shape), where[:, 0], where[:, 1])
    points, d_theta, d_phi = (
        np.asarray(table @ shape.T) for table in (tables.value, tables.d_theta, tables.d_phi)
    )
    vectors = np.cross(d_theta, d_phi) / np.sin(where[:, :1])
    return points, vectors / np.linalg.norm(vectors, axis=1, keepdims=True), vectors


def above(shape: jax.Array, where: np.ndarray, heights: np.ndarray) -> np.ndarray:
    """Points at the given heights above those of the shape."""
    points, normals, _ = surface(shape, where)
    return points + heights[:, None] * normals


def coefficients(function: Callable[..., np.ndarray], degree: int = DEGREE) -> np.ndarray:
    """Coefficients [3, K] of a function of (theta, phi) [point, 2] to vectors [point, 3]."""
    grid = sphere_grid(degree, 4 * degree)
    return (np.asarray(grid.projection) @ function(np.stack(grid.points(), axis=-1))).T


def size(vectors: np.ndarray) -> float:
    return float(np.linalg.norm(vectors, axis=-1).max())


def solid(
    densities: np.ndarray, points: np.ndarray, outside: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Newton's potentials int f(y)/|x - y| dS of densities [f, K] on the unit sphere.

    Returns the values [point, f] and gradients [point, f, 3].
    """
    degree = degree_of(densities)
    n, _ = degrees_and_orders(degree)
    r = np.linalg.norm(points, axis=1, keepdims=True)
    theta = np.arccos(points[:, 2] / r[:, 0])
    phi = np.arctan2(points[:, 1], points[:, 0])
    tables = harmonic_tables(degree, theta, phi)
    power = -n - 1 if outside else n
    radial = 4 * np.pi / (2 * n + 1) * r**power
    values = (np.asarray(tables.value) * radial) @ densities.T
    slopes = (
        (np.asarray(tables.value) * radial * power / r) @ densities.T,
        (np.asarray(tables.d_theta) * radial / r) @ densities.T,
        (np.asarray(tables.d_phi) * radial / (r * np.sin(theta)[:, None])) @ densities.T,
    )
    sine, cosine = np.sin(theta), np.cos(theta)
    frame = (
        points / r,
        np.stack([cosine * np.cos(phi), cosine * np.sin(phi), -sine], axis=-1),
        np.stack([-np.sin(phi), np.cos(phi), 0 * phi], axis=-1),
    )
    gradient = sum(s[:, :, None] * e[:, None] for s, e in zip(slopes, frame, strict=True))
    return values, gradient


@pytest.mark.parametrize("n", [0, 1, 2, 5])
@pytest.mark.parametrize("side", [1, -1])
def test_force_on_a_sphere_by_degree(
    n: int, side: int, velocity: Velocity, free_rule: CloseRule, sphere: jax.Array
) -> None:
    # r_i r_j/r^3 F_j = -(x_j - y_j) d_i(1/r) F_j: three Newton potentials and that of y.F.
    where = places(1)
    points = above(sphere, where, side * DISTANCES)
    force = np.random.default_rng(n).normal(size=(3, DEGREE**2))
    force *= degrees_and_orders(DEGREE)[0] == n
    radial = coefficients(
        lambda at: np.repeat(
            np.sum((real_harmonics(DEGREE, *at.T) @ force.T) * surface(sphere, at)[0], axis=1)[
                :, None
            ],
            3,
            axis=1,
        ),
        DEGREE + 1,
    )[:1]
    values, slopes = solid(force, points, side > 0)
    _, radial_slopes = solid(radial, points, side > 0)
    exact = values - np.einsum("pj,pji->pi", points, slopes) + radial_slopes[:, 0]
    exact /= 8 * np.pi
    found = velocity(free_rule, points, where, sphere, force=force)
    assert_allclose(found, exact, rtol=0, atol=3e-8 * size(exact))


@pytest.mark.parametrize("n", [1, 2, 5])
def test_swirl_on_a_sphere_by_degree(
    n: int, velocity: Velocity, free_rule: CloseRule, sphere: jax.Array
) -> None:
    # u = x cross grad of solid harmonics, tangential and without pressure: r^n inside, r^(-n-1)
    # outside, with the tractions (n - 1) u and -(n + 2) u on the unit sphere.
    random = np.random.default_rng(n)
    order = random.normal(size=(1, DEGREE**2)) * (degrees_and_orders(DEGREE)[0] == n)

    def swirl(at: np.ndarray) -> np.ndarray:
        points = surface(sphere, at)[0]
        return np.cross(points, solid(order, points, outside=False)[1][:, 0])

    field = coefficients(swirl)
    where = places(2)
    r = 1 + np.where(np.arange(POINTS) % 2, 1, -1) * DISTANCES
    points = above(sphere, where, r - 1)
    on_sphere = swirl(where)
    power = np.where(r > 1, r ** (-n - 1), r**n)[:, None] / (2 * n + 1)
    single = velocity(free_rule, points, where, sphere, force=field)
    assert_allclose(single, power * on_sphere, rtol=0, atol=1e-8 * size(on_sphere))
    double = velocity(free_rule, points, where, sphere, density=field)
    factor = np.where(r > 1, n - 1, -n - 2)[:, None]
    assert_allclose(double, factor * power * on_sphere, rtol=0, atol=2e-7 * size(on_sphere))


def test_double_layer_of_a_rigid_motion(
    velocity: Velocity, free_rule: CloseRule, biconcave: jax.Array
) -> None:
    where = places(3)
    sides = np.where(np.arange(POINTS) % 2, 1, -1)
    points = above(biconcave, where, sides * np.minimum(DISTANCES, 0.1))
    spin = np.array([[0.0, -0.3, 0.5], [0.3, 0.0, 0.7], [-0.5, -0.7, 0.0]])
    motion = spin @ np.asarray(biconcave)
    motion[:, 0] += UNIT_DISPLACEMENT * np.array([0.2, -1.0, 0.4])
    exact = np.where(sides > 0, 0.0, -1.0)[:, None] * (points @ spin.T + [0.2, -1.0, 0.4])
    found = velocity(free_rule, points, where, biconcave, density=motion)
    assert_allclose(found, exact, rtol=0, atol=1e-7)


def test_flow_inside_follows_from_its_boundary_values(
    velocity: Velocity, free_rule: CloseRule, biconcave: jax.Array
) -> None:
    # A straining flow u = E.x: the single layer of its traction less the double layer of u is u
    # inside, and nothing outside.
    rate = np.array([[0.7, 0.2, -0.4], [0.2, -1.1, 0.5], [-0.4, 0.5, 0.4]])
    shape = np.zeros((3, 121))
    shape[:, : DEGREE**2] = biconcave
    # n dS/dOmega has harmonics up to degree 10.
    traction = coefficients(lambda at: 2 * surface(biconcave, at)[2] @ rate, 11)
    rule = close_rule(11, parameter=FREE, farthest=0.5, radial=56, azimuthal=56)
    where = places(4)
    sides = np.where(np.arange(POINTS) % 2, 1, -1)
    points = above(biconcave, where, sides * np.minimum(DISTANCES, 0.1))
    found = velocity(rule, points, where, jnp.asarray(shape), force=traction, density=-rate @ shape)
    exact = np.where(sides > 0, 0.0, 1.0)[:, None] * (points @ rate)
    assert_allclose(found, exact, rtol=0, atol=2e-7)


@pytest.fixture(scope="module")
def rough() -> np.ndarray:
    """Force and density with all degrees alike."""
    return np.random.default_rng(5).normal(size=(2, 3, DEGREE**2))


def test_screened_kernels_against_the_ordinary_grid(
    velocity: Velocity, biconcave: jax.Array, rough: np.ndarray
) -> None:
    grid = sphere_grid(DEGREE, 40)
    at_nodes = np.stack(grid.points(), axis=-1)
    y, _, vectors = surface(biconcave, at_nodes)
    weights = np.asarray(grid.weights)[:, None]
    force, density = (np.asarray(grid.values) @ each.T * weights for each in rough)
    dyads = np.stack(
        [
            density[:, i] * vectors[:, j] + density[:, j] * vectors[:, i]
            for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
        ],
        axis=-1,
    )
    where = places(6)
    points = above(biconcave, where, np.full(POINTS, 0.5))
    given = jnp.asarray(points), jnp.asarray(y)
    single = np.asarray(block_sum(*given, jnp.asarray(force), SCREENED)) / (8 * np.pi)
    double = np.asarray(stresslet_block_sum(*given, jnp.asarray(dyads), SCREENED)) / (8 * np.pi)
    rule = close_rule(DEGREE, parameter=SCREENED, farthest=0.5, radial=56, azimuthal=56)
    found = velocity(rule, points, where, biconcave, force=rough[0])
    assert_allclose(found, single, rtol=0, atol=1e-9 * size(single))
    found = velocity(rule, points, where, biconcave, density=rough[1])
    assert_allclose(found, double, rtol=0, atol=1e-8 * size(double))


@pytest.mark.parametrize("side", [1, -1])
def test_usual_rule_is_as_good_as_its_description_says(
    side: int, velocity: Velocity, free_rule: CloseRule, biconcave: jax.Array, rough: np.ndarray
) -> None:
    where = places(7)
    points = above(biconcave, where, side * np.minimum(DISTANCES, 0.1))
    usual = close_rule(DEGREE, parameter=FREE, farthest=0.5)
    for tolerance, given in ((1e-6, {"force": rough[0]}), (3e-5, {"density": rough[1]})):
        exact = velocity(free_rule, points, where, biconcave, **given)
        found = velocity(usual, points, where, biconcave, **given)
        assert_allclose(found, exact, rtol=0, atol=tolerance * size(exact))


def test_absent_densities_are_zero(
    velocity: Velocity, free_rule: CloseRule, biconcave: jax.Array, rough: np.ndarray
) -> None:
    where = places(8)
    points = above(biconcave, where, DISTANCES)
    none = np.zeros_like(rough[0])
    given = free_rule, points, where, biconcave
    force = velocity(*given, force=rough[0])
    density = velocity(*given, density=rough[1])
    assert_allclose(velocity(*given, rough[0], none), force, rtol=0, atol=1e-13 * size(force))
    assert_allclose(velocity(*given, none, rough[1]), density, rtol=0, atol=1e-13 * size(density))
    both = velocity(*given, *rough)
    assert_allclose(both, force + density, rtol=0, atol=1e-12 * size(density))


# A rule, pairs (points, cells, guesses, valid), and fields (shapes, forces, densities).
Case = tuple[CloseRule, tuple[jax.Array, ...], tuple[jax.Array, ...]]


@pytest.fixture(scope="module")
def many(biconcave: jax.Array, rough: np.ndarray) -> Case:
    """A rule, pairs in any order, some of them not valid, of two cells, and their fields."""
    random = np.random.default_rng(9)
    count = 3 * POINTS
    cells = random.integers(0, 2, count)
    shapes = np.stack([biconcave, 1.1 * np.asarray(biconcave)])
    shapes[1, :, 0] += 0.3
    where = places(10, count)
    heights = np.geomspace(0.02, 0.3, count)[random.permutation(count)]
    points = np.stack(
        [
            above(jnp.asarray(shapes[cell]), where[i : i + 1], heights[i : i + 1])[0]
            for i, cell in enumerate(cells)
        ]
    )
    valid = random.uniform(size=count) < 0.7
    points[~valid] = np.nan
    pairs = tuple(map(jnp.asarray, (points, cells, where, valid)))
    fields = tuple(
        jnp.asarray(each)
        for each in (shapes, random.normal(size=shapes.shape), random.normal(size=shapes.shape))
    )
    return close_rule(DEGREE, parameter=SCREENED, farthest=0.4), pairs, fields


@pytest.fixture(scope="module")
def found(many: Case) -> np.ndarray:
    rule, pairs, fields = many
    return np.asarray(jax.jit(lambda rule, *all_: rule.velocity(*all_))(rule, *pairs, *fields))


def test_each_pair_as_if_it_were_alone(many: Case, found: np.ndarray, velocity: Velocity) -> None:
    rule, (points, cells, guesses, valid), fields = many
    assert not found[~valid].any()
    for cell in range(2):
        chosen = np.flatnonzero(valid & (cells == cell))[: POINTS // 2]
        padded = np.resize(chosen, POINTS)
        shape, force, density = (np.asarray(each[cell]) for each in fields)
        alone = velocity(
            rule,
            np.asarray(points)[padded],
            np.asarray(guesses)[padded],
            jnp.asarray(shape),
            force,
            density,
        )
        assert_allclose(found[padded], alone, rtol=0, atol=1e-6 * size(alone))


def test_matrices_of_the_double_layer(many: Case, found: np.ndarray) -> None:
    rule, pairs, (shapes, forces, densities) = many
    rows = jax.jit(lambda rule, *all_: rule.double_layer(*all_))(rule, *pairs, shapes)
    by_force = jax.jit(lambda rule, *all_: rule.velocity(*all_, None))(rule, *pairs, shapes, forces)
    applied = np.einsum("pijk,pjk->pi", rows, densities[pairs[1]])
    assert_allclose(applied + by_force, found, rtol=0, atol=1e-12 * size(found))


def test_derivative_against_differences(many: Case, found: np.ndarray) -> None:
    _, (points, cells, guesses, valid), fields = many
    random = np.random.default_rng(11)
    at = (jnp.where(valid[:, None], points, 0.0), *fields)
    directions = [jnp.asarray(random.normal(size=(3, *each.shape))) for each in at]
    # One direction moves points, one shapes (both by much less than the smallest distance), and the
    # last changes what they carry.
    moved = np.array([[1e-2, 0, 0, 0], [0, 1e-2, 0, 0], [0, 0, 1, 1]])
    directions = [
        each * moved[:, number].reshape(-1, *(1,) * (each.ndim - 1))
        for number, each in enumerate(directions)
    ]

    def value(rule: CloseRule, points: jax.Array, *fields: jax.Array) -> jax.Array:
        return rule.velocity(points, cells, guesses, valid, *fields)

    @jax.jit
    def changes(rule: CloseRule, directions: list[jax.Array]) -> tuple[jax.Array, jax.Array]:
        return jax.vmap(
            lambda *step: jax.jvp(lambda *at: value(rule, *at), at, step), out_axes=(None, 0)
        )(*directions)

    # As fine as the differences.
    fine = close_rule(DEGREE, parameter=SCREENED, farthest=0.4, radial=40, azimuthal=56)
    primal, exact = changes(fine, directions)
    assert_allclose(primal, found, rtol=0, atol=1e-5 * size(found))
    step = 1e-2
    compiled = jax.jit(value)
    for number in range(3):
        ahead, behind = (
            compiled(
                fine,
                *(a + sign * step * d[number] for a, d in zip(at, directions, strict=True)),
            )
            for sign in (1, -1)
        )
        difference = (ahead - behind) / (2 * step)
        assert_allclose(difference, exact[number], rtol=0, atol=3e-5 * size(exact[number]))


def test_nearest_points_of_a_deformed_cell() -> None:
    random = np.random.default_rng(12)
    shape = reference_coefficients(8, "biconcave")
    shape += 0.02 * random.normal(size=shape.shape)
    where = places(13, 200)
    heights = random.choice([-0.05, -1e-3, 1e-8, 0.01, 0.1], 200)
    points = above(jnp.asarray(shape), where, heights)
    shapes = jnp.broadcast_to(jnp.asarray(shape), (200, *shape.shape))
    guesses = jnp.asarray(where + random.uniform(-0.1, 0.1, (200, 2)))
    near = jax.jit(lambda method, *all_: method(*all_))(
        nearest_point_search(8), jnp.asarray(points), shapes, guesses
    )
    assert near.converged.all()
    assert_allclose(near.distance, heights, rtol=0, atol=1e-12)
    there = real_harmonics(8, np.asarray(near.theta), np.asarray(near.phi)) @ shape.T
    assert_allclose(there, surface(jnp.asarray(shape), where)[0], rtol=0, atol=1e-7)


def test_nearest_point_may_be_a_pole_and_never_moves_away(biconcave: jax.Array) -> None:
    # The last guess is on the far side, where a step may go anywhere.
    points = jnp.array([[0.0, 0.0, 0.4], [0.0, 0.0, -0.4], [0.0, 0.0, 0.4]])
    guesses = jnp.array([[0.2, 1.0], [3.0, 2.0], [2.9, 0.0]])
    shapes = jnp.broadcast_to(biconcave, (3, *biconcave.shape))
    near = nearest_point_search(DEGREE)(points, shapes, guesses)
    thickness = 0.207 * 0.5 * 1.38581894
    assert_allclose(near.distance[:2], 0.4 - thickness, rtol=1e-12)
    assert_allclose(near.theta[:2], [0.0, np.pi], rtol=0, atol=1e-7)
    assert_allclose(near.stretch[:2], 1.38581894, rtol=1e-10)
    first = np.linalg.norm(points[2] - surface(biconcave, np.asarray(guesses)[2:])[0][0])
    assert abs(near.distance[2]) <= first


@pytest.mark.parametrize("scale", [0.3, 1e-3])
def test_graded_nodes_integrate_what_is_peaked_at_the_scale(scale: float) -> None:
    alpha, weights = graded_nodes(scale, 40)
    assert_allclose(np.sum(weights / np.hypot(alpha, scale)), np.arcsinh(np.pi / scale), rtol=1e-8)
    assert_allclose(np.sum(weights * np.sin(alpha) * np.cos(10 * alpha)), -2 / 99, rtol=1e-8)
