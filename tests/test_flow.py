"""Flow in the tube: what holds whatever the splitting and the geometry.

Loose points are rings of one azimuth; sources are two cells of point forces in a tube of radius
2.5, all within 1.2 of the axis.
"""

import math
from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import erfc

from celltrain.clock import compilation
from celltrain.flow import PeriodicTube, Sources, periodic_tube
from celltrain.flow.ewald import near_scalars, near_slopes
from celltrain.flow.near import BAND, _in_bands, block_sum, near_sum
from celltrain.proximity.chunks import CHUNK

RADIUS, PERIOD = 2.5, 4.0
LOOSE = jnp.array([-1])
Velocity = Callable[..., jax.Array]


def make_tube(periods: int = 1, **changes: object) -> PeriodicTube:
    settings = {"wall_gap": 1.0, "extent": 2.0, "cutoff": 2.5, "tolerance": 1e-9}
    return periodic_tube(2 * RADIUS, periods * PERIOD, **{**settings, **changes})


def cloud(seed: int, count: int, radius: float, length: float) -> np.ndarray:
    """Random points [count, 3] in a cylinder about the origin."""
    random = np.random.default_rng(seed)
    angle, r = random.uniform(0, 2 * np.pi, count), radius * np.sqrt(random.uniform(size=count))
    z = random.uniform(-0.5 * length, 0.5 * length, count)
    return np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=-1)


@pytest.fixture(scope="session")
def velocity() -> Velocity:
    """Velocity at loose points [target, 3] by forces [cell, source, 3], compiled once a size."""

    @jax.jit
    def compiled(tube, targets, sources, strengths):
        forces = Sources(sources[:, :, None], strengths[:, :, None])
        return tube.velocity(targets[None, :, None], LOOSE, forces)[0, :, 0]

    return compiled


@pytest.fixture(scope="session")
def change() -> Callable[..., tuple[jax.Array, jax.Array]]:
    """Value and derivative of the velocity in all of targets, sources and strengths."""

    @jax.jit
    def compiled(tube, points, steps):
        def total(targets, sources, strengths):
            return tube.velocity(targets, LOOSE, Sources(sources, strengths))

        return jax.jvp(total, points, steps)

    return compiled


@pytest.fixture(scope="session")
def tube() -> PeriodicTube:
    return make_tube()


@pytest.fixture(scope="module")
def sources() -> np.ndarray:
    return cloud(1, 24, 1.2, 3.0).reshape(2, 12, 3)


@pytest.fixture(scope="module")
def forces() -> np.ndarray:
    """Forces with a net force of the size of one of them."""
    return np.random.default_rng(2).normal(size=(2, 12, 3))


@pytest.fixture(scope="module")
def targets() -> np.ndarray:
    return cloud(3, 24, 2.0, 2 * PERIOD)


def test_a_tube_is_made_without_a_program() -> None:
    """Of sizes that nothing else has: what JAX makes by itself it compiles for each."""
    before = compilation.seconds()
    made = make_tube(periods=3, wall_gap=0.71, cutoff=1.7)
    assert made.wall_synthesis.phases.size > 0
    assert compilation.seconds() == before


def test_near_kernel_against_its_definition() -> None:
    parameter, radius = 1.7, np.geomspace(1e-3, 4.0, 60)
    gauss = 2 * parameter / math.sqrt(math.pi) * np.exp(-((parameter * radius) ** 2))
    screened = erfc(parameter * radius) / radius
    isotropic, dyadic = near_scalars(jnp.asarray(radius**2), parameter)
    assert_allclose(isotropic, screened - gauss, rtol=1e-11, atol=1e-11)
    assert_allclose(dyadic * radius**2, screened + gauss, rtol=1e-11)

    def slopes(step: float) -> np.ndarray:
        ahead, behind = (
            np.stack(near_scalars(jnp.asarray((radius * (1 + sign * step)) ** 2), parameter))
            for sign in (1, -1)
        )
        return (ahead - behind) / (2 * step * radius**2)

    exact = np.stack(near_slopes(jnp.asarray(radius**2), parameter))
    scale = np.stack([radius**3, radius**5])
    assert_allclose(scale * slopes(1e-4), scale * exact, rtol=0, atol=1e-6)


def test_near_sum_is_the_sum_over_pairs_within_the_cutoff() -> None:
    # Neither a multiple of the chunk nor less than one; two groups that own a cell, one that does
    # not.
    random = np.random.default_rng(4)
    targets = random.uniform(-1, 1, size=(3, CHUNK + 7, 3)) + np.array([3.0, 0.0, 0.0])
    owners = np.array([1, 0, -1])
    sources, strengths = random.uniform(-1, 1, size=(2, 2, 9, 3))
    summed = near_sum(
        jnp.asarray(targets),
        jnp.asarray(owners),
        Sources(jnp.asarray(sources)[:, :, None], jnp.asarray(strengths)[:, :, None]),
        parameter=0.8,
        cutoff=3.5,
        period=jnp.asarray(2.2),
        images=2,
    )
    expected = np.zeros((3, CHUNK + 7, 3))
    for shift in range(-2, 3):
        for group, owner in enumerate(owners):
            for cell in range(2):
                if cell == owner and shift == 0:
                    continue
                d = targets[group][:, None] - sources[cell] - [0.0, 0.0, 2.2 * shift]
                r = np.linalg.norm(d, axis=-1)
                gauss = 2 * 0.8 / math.sqrt(math.pi) * np.exp(-((0.8 * r) ** 2))
                screened = erfc(0.8 * r) / r
                gauss[r >= 3.5] = screened[r >= 3.5] = 0.0
                along = (screened + gauss) / r**2 * np.einsum("tsi,si->ts", d, strengths[cell])
                expected[group] += (screened - gauss) @ strengths[cell]
                expected[group] += np.einsum("ts,tsi->ti", along, d)
    assert_allclose(summed, expected, rtol=0, atol=1e-12)


def test_a_target_that_is_no_number_changes_no_other() -> None:
    random = np.random.default_rng(6)
    targets, sources, strengths = random.uniform(-1, 1, size=(3, 1, 20, 3))
    given = Sources(jnp.asarray(sources)[:, :, None], jnp.asarray(strengths)[:, :, None])
    ranges = {"parameter": 0.8, "cutoff": 3.5, "period": jnp.asarray(9.0), "images": 0}
    expected = near_sum(jnp.asarray(targets), LOOSE, given, **ranges)
    targets[0, 3] = np.nan
    found = np.array(near_sum(jnp.asarray(targets), LOOSE, given, **ranges))
    assert np.isnan(found[0, 3]).all()
    found[0, 3] = expected[0, 3]
    assert_allclose(found, expected, rtol=0, atol=1e-14)


@pytest.mark.parametrize("rings", [4, 10, 15])
def test_sources_that_follow_each_other_are_neighbours(rings: int) -> None:
    """So that few patches of them are large."""
    azimuths = 7
    places = np.stack(np.meshgrid(np.arange(rings), np.arange(azimuths), indexing="ij"), axis=-1)
    found = np.asarray(_in_bands(jnp.asarray(places, dtype=float)[None]))[0]
    assert len({tuple(each) for each in found}) == rings * azimuths
    assert np.abs(np.diff(found[:, 0])).max() < 2 * BAND
    assert np.abs(np.diff(found[:, 1])).max() == 1


def test_near_sum_leaves_out_what_is_out_of_range() -> None:
    def one(height: float) -> np.ndarray:
        return np.asarray(
            near_sum(
                jnp.array([[[0.5, 0.0, height]]]),
                LOOSE,
                Sources(jnp.zeros((1, 1, 1, 3)), jnp.ones((1, 1, 1, 3))),
                parameter=1.0,
                cutoff=2.0,
                period=jnp.asarray(20.0),
                images=0,
            )
        )

    assert np.all(one(1.9) != 0.0)
    assert np.all(one(-1.9) != 0.0)
    assert np.all(one(2.1) == 0.0)
    assert np.all(one(-2.1) == 0.0)


def test_derivative_of_the_near_sum(difference_order: Callable[..., float]) -> None:
    random = np.random.default_rng(5)
    at = random.uniform(-1, 1, size=(3, 10, 3)) + np.array([2.0, 0.0, 0.0])[:, None, None]
    step = random.normal(size=at.shape)

    def total(parts: jax.Array) -> jax.Array:
        return block_sum(parts[0], parts[1], parts[2], 0.9)

    assert difference_order(jax.jit(total), at, step, (1e-2, 1e-3)) == pytest.approx(2, abs=0.05)


def test_result_does_not_depend_on_the_splitting(
    velocity: Velocity,
    tube: PeriodicTube,
    sources: np.ndarray,
    forces: np.ndarray,
    targets: np.ndarray,
) -> None:
    balanced = forces - forces.mean(axis=(0, 1))
    others = [make_tube(cutoff=2.0), make_tube(cutoff=3.5)]
    for strengths in (forces, balanced):
        expected = velocity(tube, targets, sources, strengths)
        for other in others:
            found = velocity(other, targets, sources, strengths)
            assert_allclose(found, expected, rtol=0, atol=1e-8)


def test_nothing_moves_on_the_wall(
    velocity: Velocity, tube: PeriodicTube, sources: np.ndarray, forces: np.ndarray
) -> None:
    random = np.random.default_rng(6)
    angle, z = random.uniform(0, 2 * np.pi, 24), random.uniform(-PERIOD, PERIOD, 24)
    wall = np.stack([RADIUS * np.cos(angle), RADIUS * np.sin(angle), z], axis=-1)
    inside = wall * [0.7, 0.7, 1.0]
    size = np.abs(velocity(tube, inside, sources, forces)).max()
    assert size > 0.1
    assert_allclose(velocity(tube, wall, sources, forces), 0.0, atol=5e-9 * size)


def test_flow_is_divergence_free(
    change: Callable[..., tuple[jax.Array, jax.Array]],
    tube: PeriodicTube,
    sources: np.ndarray,
    forces: np.ndarray,
    targets: np.ndarray,
) -> None:
    points = targets[None, :, None], sources[:, :, None], forces[:, :, None]
    still = np.zeros_like(points[1])
    slopes = np.stack(
        [
            change(tube, points, (np.broadcast_to(axis, points[0].shape), still, still))[1]
            for axis in np.eye(3)
        ]
    )
    divergence = np.einsum("igtai->gta", slopes)
    assert_allclose(divergence, 0.0, atol=5e-10 * np.abs(slopes).max())


def test_derivative_of_the_flow(
    velocity: Velocity,
    change: Callable[..., tuple[jax.Array, jax.Array]],
    tube: PeriodicTube,
    sources: np.ndarray,
    forces: np.ndarray,
    targets: np.ndarray,
) -> None:
    # Along targets, sources and forces at once.
    points = targets, sources, forces
    random = np.random.default_rng(17)
    steps = tuple(random.normal(size=each.shape) for each in points)
    loose = tuple(
        (one[None, :, None], *(each[:, :, None] for each in others))
        for one, *others in (points, steps)
    )
    value, exact = (np.asarray(each)[0, :, 0] for each in change(tube, *loose))
    assert_allclose(velocity(tube, *points), value, rtol=0, atol=1e-10)

    def error(h: float) -> float:
        ahead, behind = (
            velocity(tube, *(p + sign * h * s for p, s in zip(points, steps, strict=True)))
            for sign in (1, -1)
        )
        return float(np.abs((ahead - behind) / (2 * h) - exact).max() / np.abs(exact).max())

    assert np.log10(error(1e-2) / error(1e-3)) == pytest.approx(2, abs=0.1)
    assert error(1e-4) < 1e-5


def test_reciprocity(velocity: Velocity, tube: PeriodicTube) -> None:
    random = np.random.default_rng(7)
    here, there = cloud(8, 24, 1.2, PERIOD), cloud(9, 24, 1.2, PERIOD)
    force_here, force_there = random.normal(size=(2, 24, 3))

    def disturbance(at: np.ndarray, by: np.ndarray, strengths: np.ndarray) -> np.ndarray:
        pairs = by.reshape(2, 12, 3), strengths.reshape(2, 12, 3)
        return velocity(tube, at, *pairs) - velocity(tube, at, pairs[0], 0 * pairs[1])

    forth = np.sum(force_here * disturbance(here, there, force_there))
    back = np.sum(force_there * disturbance(there, here, force_here))
    assert abs(forth) > 0.1
    assert_allclose(back, forth, rtol=2e-8)


def test_without_forces_the_flow_is_poiseuilles(
    velocity: Velocity, tube: PeriodicTube, sources: np.ndarray, targets: np.ndarray
) -> None:
    found = velocity(tube, targets, sources, np.zeros_like(sources))
    profile = 2 * (1 - (targets[:, 0] ** 2 + targets[:, 1] ** 2) / RADIUS**2)
    assert_allclose(found, profile[:, None] * [0.0, 0.0, 1.0], rtol=0, atol=1e-14)


def test_flow_rate_is_held(velocity: Velocity, tube: PeriodicTube, forces: np.ndarray) -> None:
    sources = cloud(10, 24, 1.2, 1.2).reshape(2, 12, 3)
    nodes, weights = np.polynomial.legendre.leggauss(8)
    square, azimuths = 0.5 * (nodes + 1), 18
    angle = 2 * np.pi * np.arange(azimuths) / azimuths
    r = RADIUS * np.sqrt(square)[:, None]
    section = np.stack(
        np.broadcast_arrays(r * np.cos(angle), r * np.sin(angle), 0.5 * PERIOD), axis=-1
    )
    found = velocity(tube, section.reshape(-1, 3), sources, forces)[:, 2]
    # int u r dr dtheta = (R^2/2) int u d(r^2/R^2) dtheta.
    rate = 0.5 * weights @ found.reshape(square.size, azimuths).mean(axis=1)
    disturbed = found.reshape(square.size, azimuths) - 2 * (1 - square[:, None])
    assert np.abs(disturbed).max() > 0.01
    assert_allclose(rate, 1.0, rtol=0, atol=2e-8)


def test_turned_and_mirrored_forces_give_a_turned_and_mirrored_flow(
    velocity: Velocity,
    tube: PeriodicTube,
    sources: np.ndarray,
    forces: np.ndarray,
    targets: np.ndarray,
) -> None:
    def disturbance(map_: np.ndarray, shift: float) -> np.ndarray:
        moved = [points @ map_.T + [0.0, 0.0, shift] for points in (targets, sources)]
        strengths = forces @ map_.T
        return velocity(tube, *moved, strengths) - velocity(tube, *moved, 0 * strengths)

    expected = disturbance(np.eye(3), 0.0)
    cosine, sine = np.cos(0.7), np.sin(0.7)
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    maps = [turn, np.diag([1.0, -1.0, 1.0]), np.diag([1.0, 1.0, -1.0]), np.eye(3)]
    for map_, shift in zip(maps, (0.0, 0.0, 0.0, 1.234), strict=True):
        assert_allclose(disturbance(map_, shift), expected @ map_.T, rtol=0, atol=1e-8)
