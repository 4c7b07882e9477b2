"""Cells close to each other and to the wall, tilted, off the axis, of any viscosity."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from celltrain import Train
from celltrain.harmonics import UNIT_DISPLACEMENT, degrees_and_orders
from celltrain.harmonics.grid import sphere_grid
from celltrain.proximity.overlaps import overlaps
from celltrain.train import CellsOperator, rates_error, resting_shapes, train_operator
from celltrain.train.accuracy import _velocity, refined

DEGREE, CELLS = 6, 2
# All cases share one program: the period, the wall and the grids are the same.
TRAIN = Train(
    diameter=6,
    packing=0.4,
    cells=CELLS,
    degree=DEGREE,
    source_order=24,
    target_order=14,
    polar_radial=20,
    polar_azimuthal=28,
    near_cutoff=2.0,
    viscosity_ratio=5.0,
)
GAP = 0.3


@eqx.filter_jit
def rates(operator: CellsOperator, shapes: jax.Array) -> jax.Array:
    return operator.rates(shapes)


@eqx.filter_jit
def velocity_of(operator: CellsOperator, shapes: jax.Array, forces: jax.Array) -> jax.Array:
    """Velocity by given forces at a viscosity ratio of 1, without a mean flow."""
    targets, sources = operator.targets(shapes), operator.sources(shapes, forces)
    own = operator.own_velocity(targets, shapes, forces)
    outer = operator.flow.velocity(targets, jnp.arange(CELLS), sources, background=False)
    return own + outer


@eqx.filter_jit
def at_points(
    operator: CellsOperator, points: jax.Array, shapes: jax.Array, motions: jax.Array
) -> jax.Array:
    return operator.velocity_at(points, shapes, motions)


@pytest.fixture(scope="module")
def operator() -> CellsOperator:
    return train_operator(TRAIN, cells=CELLS, wall_gap=GAP)


def turn(axis: np.ndarray, angle: float) -> np.ndarray:
    """Matrix of a rotation."""
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def configuration(seed: int) -> np.ndarray:
    """Two cells, tilted, deformed, off the axis, 0.05 r0 or less apart, neither overlapping."""
    random = np.random.default_rng(seed)
    shapes = resting_shapes(TRAIN, 1).repeat(CELLS, axis=0)
    low = np.arange(DEGREE**2) < 9
    shapes = shapes + 0.04 * low * random.normal(size=shapes.shape)
    shapes[:, :, 0] = 0.0
    for cell in range(CELLS):
        shapes[cell] = turn(random.normal(size=3), random.uniform(0, 3)) @ shapes[cell]
    across = random.uniform(-0.4, 0.4, size=(CELLS, 2))
    shapes[:, :2, 0] = across * UNIT_DISPLACEMENT
    # The closest approach without an overlap, found by halving.
    near, far = 0.0, 0.5 * TRAIN.length
    for _ in range(8):
        middle = 0.5 * (near + far)
        shapes[1, 2, 0] = middle * UNIT_DISPLACEMENT
        touching = overlaps(shapes, period=TRAIN.length)
        near, far = (middle, far) if touching else (near, middle)
    shapes[1, 2, 0] = (far + random.uniform(0.01, 0.05)) * UNIT_DISPLACEMENT
    return shapes


@pytest.mark.parametrize("gap", [0.5, 0.1, 0.02, 0.005])
def test_two_spheres_approaching(gap: float) -> None:
    """Smooth forces on two spheres, against finer rules for the same shapes."""
    train = TRAIN.changed(reference="sphere", viscosity_ratio=1.0, degree=8)
    shapes = resting_shapes(train, 2)
    apart = (2 + gap) * UNIT_DISPLACEMENT
    shapes[1, :, 0] = shapes[0, :, 0] + apart * np.array([0.4, 0.0, np.sqrt(1 - 0.16)])
    forces = np.zeros_like(shapes)
    forces[..., :9] = np.random.default_rng(0).normal(size=(2, 3, 9))
    found = []
    for order, degree in ((24, 8), (40, 14)):
        finer = train.changed(degree=degree, source_order=order, polar_radial=30)
        finer = finer.changed(polar_azimuthal=44, tolerance=1e-8, target_order=14)
        padding = ((0, 0), (0, 0), (0, degree**2 - 64))
        padded = (jnp.asarray(np.pad(each, padding)) for each in (shapes, forces))
        operator = train_operator(finer, cells=2)
        found.append(np.asarray(velocity_of(operator, *padded)))
    error = np.linalg.norm(found[0] - found[1], axis=-1).max()
    assert error < 1e-4 * np.linalg.norm(found[1], axis=-1).max()


@pytest.mark.slow
def test_estimate_bounds_the_effect_of_each_rule() -> None:
    # So fine that what the target grid leaves is most of the error.
    train = TRAIN.changed(
        viscosity_ratio=1.0,
        source_order=28,
        polar_radial=26,
        polar_azimuthal=40,
        energy_order=30,
        tolerance=1e-7,
    )
    shapes = configuration(1)
    estimate = rates_error(train, shapes, wall_gap=GAP)
    assert estimate < 1e-3

    # By the estimate's own program, and at its points.
    values = sphere_grid(train.degree, refined(train).sizes.target_order).values

    def velocity(**changes: int) -> np.ndarray:
        operator = train_operator(train.changed(**changes), cells=CELLS, wall_gap=GAP)
        return np.asarray(_velocity(operator, values, jnp.asarray(shapes)))

    expected = velocity()
    for finer in ({"source_order": 34}, {"target_order": 2 * train.sizes.target_order}):
        change = np.linalg.norm(velocity(**finer) - expected, axis=-1).max()
        assert 0.0 < change < estimate * np.linalg.norm(expected, axis=-1).max()


@pytest.mark.slow
@settings(
    max_examples=2,
    derandomize=True,
    # A smaller example says no more, and takes as long.
    phases=[Phase.generate],
    suppress_health_check=list(HealthCheck),
)
@given(seed=st.integers(0, 10**6), ratio=st.sampled_from([0.02, 0.5, 5.0, 200.0]))
def test_any_configuration(operator: CellsOperator, seed: int, ratio: float) -> None:
    shapes = configuration(seed)
    this = eqx.tree_at(lambda each: each.viscosity_ratio, operator, jnp.asarray(ratio))
    found = np.asarray(rates(this, jnp.asarray(shapes)))
    size = np.abs(found).max()
    assert np.isfinite(size)
    # Turned about the axis.
    matrix = turn(np.array([0.0, 0.0, 1.0]), 0.7)
    turned = rates(this, jnp.asarray(matrix @ shapes))
    assert_allclose(turned, matrix @ found, rtol=0, atol=2e-5 * size)
    # Mirrored, in longitude, too, so that the outside stays outside.
    _, order = degrees_and_orders(DEGREE)
    mirror = np.diag([1.0, -1.0, 1.0])
    sign = np.where(order < 0, -1.0, 1.0)
    mirrored = rates(this, jnp.asarray(mirror @ shapes * sign))
    assert_allclose(mirrored, mirror @ found * sign, rtol=0, atol=2e-5 * size)
    # Moved along it, beyond the period's end.
    moved = shapes.copy()
    moved[:, 2, 0] += 0.4 * TRAIN.length * UNIT_DISPLACEMENT
    assert_allclose(rates(this, jnp.asarray(moved)), found, rtol=0, atol=2e-5 * size)


def test_reciprocity_of_close_cells(operator: CellsOperator) -> None:
    random = np.random.default_rng(5)
    shapes = jnp.asarray(configuration(3))
    first, second = random.normal(size=(2, *shapes.shape)) * (np.arange(DEGREE**2) < 16)

    def power(forces: np.ndarray, others: np.ndarray) -> float:
        velocity = velocity_of(operator, shapes, jnp.asarray(forces))
        return float(jnp.sum(jnp.asarray(others) * operator.project(velocity)))

    # What is left is the target grid's error for the velocity in the gap.
    scale = np.sqrt(power(first, first) * power(second, second))
    assert_allclose(power(first, second), power(second, first), rtol=0, atol=1e-4 * scale)


@pytest.mark.slow
def test_flow_up_to_a_membrane(operator: CellsOperator) -> None:
    """Continuous across the membrane, no slip at the wall, no divergence, at a ratio of 5."""
    shapes = jnp.asarray(configuration(6))
    surface = np.asarray(operator.targets(shapes)[0, 4, ::4])
    normal = surface - np.asarray(shapes[0, :, 0]) / UNIT_DISPLACEMENT
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    angle = np.linspace(0, 6, len(surface))
    wall = np.stack([3 * np.cos(angle), 3 * np.sin(angle), np.linspace(-2, 3, angle.size)], axis=-1)
    step = 1e-3
    around = surface + 0.1 * normal
    around = around + step * np.array([1, -1])[:, None, None, None] * np.eye(3)[:, None]
    sides = [surface + distance * normal for distance in (step, -step)]
    points = np.concatenate([*sides, wall, around.reshape(-1, 3)])
    motions = rates(operator, shapes)
    found = np.asarray(at_points(operator, jnp.asarray(points), shapes, motions))
    assert np.all(np.isfinite(found))
    outside, inside, at_wall = found[: 3 * angle.size].reshape(3, -1, 3)
    assert_allclose(outside, inside, rtol=0, atol=2e-2 * np.abs(outside).max())
    assert_allclose(at_wall, 0.0, atol=2e-5)
    ahead, behind = found[3 * angle.size :].reshape(around.shape)
    slope = (ahead - behind) / (2 * step)
    divergence = sum(slope[i, :, i] for i in range(3))
    assert_allclose(divergence, 0.0, atol=1e-3 * np.abs(slope).max())
