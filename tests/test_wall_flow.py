"""The flow inside a tube from its velocity on the wall, beside flows that are known everywhere."""

from collections.abc import Callable
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import ive, ivp

from celltrain.flow.wall import TubeWall, tube_wall

RADIUS, PERIOD = 1.7, 5.0
#: On the axis, near it, in the fluid, at the wall, and beyond the period.
PLACES = np.array([0.0, 1e-7, 0.4, 1.1, 1.6999999, 1.7])
ANGLES = np.array([0.3, 2.0, -1.1, 3.0, -2.5, 0.0])
HEIGHTS = np.array([0.1, 4.9, -7.2, 12.0, 2.5, 5.0])
#: Points on the axis are taken 1e-9 r0 off it, where they have a direction.
OFF_AXIS = 2e-9
#: Distance from the wall of the nearest cell.
GAP = 0.15


def potential_flow(m: int, wave: int, points: np.ndarray) -> np.ndarray:
    """grad I_m(k r) cos(m theta) sin(k z), scaled by exp(-k R): a Stokes flow without pressure."""
    k = 2.0 * np.pi * wave / PERIOD
    r, theta = np.hypot(points[..., 0], points[..., 1]), np.arctan2(points[..., 1], points[..., 0])
    scale = np.exp(k * (r - RADIUS))
    value, slope = ive(m, k * r) * scale, k * ivp(m, k * r) * np.exp(-k * RADIUS)
    # I_m(x)/x from its recurrence has a value on the axis, too.
    around = 0.5 * k * (ive(abs(m - 1), k * r) - ive(m + 1, k * r)) * scale if m else 0.0 * r
    u_r = slope * np.cos(m * theta) * np.sin(k * points[..., 2])
    u_theta = -around * np.sin(m * theta) * np.sin(k * points[..., 2])
    u_z = k * value * np.cos(m * theta) * np.cos(k * points[..., 2])
    cosine, sine = np.cos(theta), np.sin(theta)
    return np.stack([u_r * cosine - u_theta * sine, u_r * sine + u_theta * cosine, u_z], axis=-1)


def flow_with_pressure(m: int, wave: int, points: np.ndarray) -> np.ndarray:
    """x grad phi - phi e_x of the same phi, whose pressure is 2 d phi/dx."""
    k = 2.0 * np.pi * wave / PERIOD
    r, theta = np.hypot(points[..., 0], points[..., 1]), np.arctan2(points[..., 1], points[..., 0])
    value = ive(m, k * r) * np.exp(k * (r - RADIUS))
    value = value * np.cos(m * theta) * np.sin(k * points[..., 2])
    flow = points[..., :1] * potential_flow(m, wave, points)
    flow[..., 0] -= value
    return flow


def points() -> np.ndarray:
    return np.stack([PLACES * np.cos(ANGLES), PLACES * np.sin(ANGLES), HEIGHTS], axis=-1)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-11])
@pytest.mark.parametrize("known", [potential_flow, flow_with_pressure])
def test_known_flows(known: Callable[..., np.ndarray], tolerance: float) -> None:
    wall = tube_wall(RADIUS, PERIOD, wall_gap=0.4, tolerance=tolerance)
    for m, wave in ((0, 1), (1, 2), (2, 1), (5, 7), (11, 3), (3, 12)):
        boundary = known(m, wave, np.asarray(wall.points()))
        flow = wall.regular_flow(jnp.asarray(boundary))
        found = wall.velocity(jnp.asarray(points()), flow)
        allowed = max(5.0 * tolerance, OFF_AXIS) * np.abs(boundary).max()
        assert_allclose(found, known(m, wave, points()), rtol=0, atol=allowed)


def errors(wall: TubeWall, mode: tuple[int, int], here: np.ndarray) -> np.ndarray:
    """Of a mode as large as a cell at the gap makes it, at points, relative to all on the wall."""
    m, wave = mode
    boundary = potential_flow(m, wave, np.asarray(wall.points()))
    amplitude = np.exp(-GAP * np.hypot(2.0 * np.pi * wave / PERIOD, m / RADIUS))
    found = wall.velocity(jnp.asarray(here), wall.regular_flow(jnp.asarray(boundary)))
    wrong = np.abs(np.asarray(found) - potential_flow(m, wave, here)).max(axis=1)
    return np.asarray(amplitude * wrong / np.abs(boundary).max())


def test_nodes_serve_flows_of_cells_that_are_no_nearer() -> None:
    """Of a cell at the gap the wall has a mode in exp(-k gap) of its size; k = 61 is hardest.

    Transforms that are exact leave the nodes' error. Usual ones add to it on the wall, where modes
    are least resolved, hardly where the cell may be.
    """
    tolerance = 1e-8
    wall = tube_wall(RADIUS, PERIOD, wall_gap=GAP, tolerance=tolerance)
    exact = replace(wall, tolerance=1e-12)
    random, r = np.random.default_rng(0), np.linspace(0.0, RADIUS, 200)
    theta, z = random.uniform(-3.0, 3.0, (2, r.size))
    here = np.stack([r * np.cos(theta), r * np.sin(theta), z], axis=-1)
    most, longest = wall.azimuths // 2, wall.rings // 2
    usual = ((0, 20), (3, 35), (0, 49), (8, 49), (2, 65))
    for mode in (*usual, (most, 2), (0, longest)):
        assert errors(exact, mode, here).max() < (0.01 if mode in usual else 0.03) * tolerance
        found = errors(wall, mode, here)
        assert found.max() < 0.5 * tolerance
        assert found[r < RADIUS - GAP].max() < 0.03 * tolerance


def test_derivatives_along_a_direction() -> None:
    wall = tube_wall(RADIUS, PERIOD, wall_gap=0.4, tolerance=1e-11)
    flow = wall.regular_flow(jnp.asarray(potential_flow(2, 3, np.asarray(wall.points()))))
    here = points()[1:-1]
    along = np.random.default_rng(0).normal(size=here.shape)
    _, found = jax.jvp(lambda each: wall.velocity(each, flow), (here,), (along,))
    step = 1e-5
    ahead, behind = (potential_flow(2, 3, here + sign * step * along) for sign in (1.0, -1.0))
    assert_allclose(found, (ahead - behind) / (2.0 * step), rtol=0, atol=1e-6 * np.abs(found).max())


def test_uniform_and_turning_flows() -> None:
    """Along the tube, across it, and turning about its axis."""
    wall = tube_wall(RADIUS, PERIOD, wall_gap=0.8, tolerance=1e-12)
    here, on_wall = points(), np.asarray(wall.points())
    turned = np.stack([-here[:, 1], here[:, 0], 0.0 * here[:, 0]], axis=-1)
    turned_wall = np.stack([-on_wall[..., 1], on_wall[..., 0], 0.0 * on_wall[..., 0]], axis=-1)
    for velocity in np.eye(3):
        boundary = jnp.asarray(np.broadcast_to(velocity, on_wall.shape))
        found = wall.velocity(jnp.asarray(here), wall.regular_flow(boundary))
        assert_allclose(found, np.broadcast_to(velocity, here.shape), rtol=0, atol=OFF_AXIS)
    found = wall.velocity(jnp.asarray(here), wall.regular_flow(jnp.asarray(turned_wall)))
    assert_allclose(found, turned, rtol=0, atol=OFF_AXIS)
