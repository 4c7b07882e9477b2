"""The tube's wall: nothing moves on it, whatever the cells do."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain.harmonics import Profile
from celltrain.meridian import flow_rate, wall
from celltrain.meridian.geometry import volume_gradient
from celltrain.meridian.grids import HalfCircle, MeridianGrid, meridian_grid
from celltrain.meridian.images import force_image, stress_image
from celltrain.meridian.moments import SINGLE, SLOPE, STRESS, member_matrix
from celltrain.meridian.tail import Tail
from celltrain.meridian.wall import WallFlow, WallWaves

DEGREE, SIZE = 4, 40
PERIOD, RADIUS = 2.3, 1.6
NEAREST = 1
CIRCLE = HalfCircle(32)
LARGEST = 3

Targets = tuple[np.ndarray, np.ndarray]


def cell() -> Profile:
    profile = np.zeros((2, DEGREE))
    profile[:, 1] = 0.9, 2.4
    profile[0, 2:] += [0.3, -0.1]
    profile[1, 2:] += [-0.2, 0.1]
    return profile


def force() -> Profile:
    """Without a resultant."""
    random = np.random.default_rng(5).normal(size=(2, DEGREE))
    random[:, 0] = 0.0
    return random


def grid() -> MeridianGrid:
    return meridian_grid(DEGREE, SIZE)


def unforced(m: int) -> np.ndarray:
    """From members to those without a resultant: all but those of degree 0."""
    unit = np.eye(grid().members(m).shape[1])
    for place in {0: [0], 1: [2 * DEGREE - 3]}.get(m, []):
        unit[place, place] = 0.0
    return unit


def uninflated(m: int) -> np.ndarray:
    """From members to those that change no volume."""
    unit = np.eye(grid().members(m).shape[1])
    if m > 0:
        return unit
    n = volume_gradient(cell())
    return unit - np.outer(n, n) / (n @ n)


class Flow:
    """Velocities [target, 3, member] at any places in the tube away from the cell."""

    def __init__(self, targets: Targets, m: int, phase: float) -> None:
        self.m, self.phase, self.targets = m, phase, targets
        z, rho = grid().places(cell())
        heights = np.concatenate([z, targets[0]])
        self.tail = Tail(
            period=PERIOD,
            nearest=NEAREST,
            distance=(NEAREST + 1) * PERIOD - float(np.ptp(heights)),
            smallest_phase=abs(phase) or 0.5,
            tolerance=1e-13,
            sources=(z, rho),
            targets=targets,
            orders=LARGEST + 3,
        )
        waves = WallWaves(
            phase=phase,
            radius=RADIUS,
            period=PERIOD,
            # Targets on the wall leave only the cells' half of the distance.
            wall_distance=0.5 * (RADIUS - float(rho.max())),
            tolerance=1e-11,
            rho=np.concatenate([rho, targets[1]]),
            z=heights,
            sources=SIZE,
            orders=LARGEST + 3,
        )
        self.wall = WallFlow(waves, m)

    def _summed(self, near: Callable[[float], np.ndarray]) -> np.ndarray:
        numbers = range(-NEAREST, NEAREST + 1)
        return sum((np.exp(1j * self.phase * p) * near(p * PERIOD) for p in numbers), 0j)

    def of_forces(self, forces: np.ndarray) -> np.ndarray:
        """Displacements of the carried forces together with forces (a matrix of members)."""
        m, places = self.m, grid().places(force())
        displaced = grid().sources(m)

        def near(shift: float) -> np.ndarray:
            one = force_image(grid(), CIRCLE, self.targets, cell(), force(), shift, m + 2)
            single, slope = (member_matrix(one.at, part, m) for part in (SINGLE, SLOPE))
            return single @ forces - slope

        far = self.tail.of_forces(m, places, displaced, displaced @ forces)
        wall = self.wall.of_forces(places, displaced, displaced @ forces)
        velocity = self.tail.velocity(m, self.phase, far) + self.wall.velocity(wall)
        return self._summed(near) + velocity

    def of_stresses(self, content: np.ndarray) -> np.ndarray:
        """The double layer of members' combinations."""
        m, area = self.m, grid().area_vectors(cell())
        displaced = grid().sources(m) @ content

        def near(shift: float) -> np.ndarray:
            one = stress_image(grid(), CIRCLE, self.targets, cell(), shift, m + 2)
            return member_matrix(one.at, STRESS, m) @ content

        far = self.tail.of_stresses(m, area, displaced)
        wall = self.wall.of_stresses(area, displaced)
        velocity = self.tail.velocity(m, self.phase, far) + self.wall.velocity(wall)
        return self._summed(near) + velocity


def on_the_wall() -> Targets:
    z = np.array([-0.9, -0.2, 0.0, 0.4, 1.0])
    return z, np.full_like(z, RADIUS)


PHASES = [0.0, 0.003, 0.8, np.pi, -2.1]


@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize("m", range(LARGEST + 1))
def test_nothing_moves_on_the_wall(m: int, phase: float) -> None:
    flow = Flow(on_the_wall(), m, phase)
    within = Flow((np.array([0.3]), np.array([1.3])), m, phase)
    for at_wall, inside in (
        (flow.of_forces(unforced(m)), within.of_forces(unforced(m))),
        (flow.of_stresses(uninflated(m)), within.of_stresses(uninflated(m))),
    ):
        assert np.abs(inside).max() > 1e-2
        assert_allclose(at_wall, 0.0, atol=2e-10)


@pytest.mark.parametrize("phase", [0.0, 1.3])
@pytest.mark.parametrize("m", range(LARGEST + 1))
def test_flow_inside_the_tube_is_incompressible(m: int, phase: float) -> None:
    h, r = 1e-3, 1.35
    z = 0.3 + h * np.array([0, 0, 0, -1, 1, 0, 0, -2, 2])
    rho = r + h * np.array([0, -1, 1, 0, 0, -2, 2, 0, 0])
    flow = Flow((z, rho), m, phase)
    for velocity in (flow.of_forces(unforced(m)), flow.of_stresses(uninflated(m))):
        radial, axial = velocity[:, 0], velocity[:, 2]
        by_radius = (8 * (radial[2] - radial[1]) - radial[6] + radial[5]) / (12 * h)
        by_height = (8 * (axial[4] - axial[3]) - axial[8] + axial[7]) / (12 * h)
        divergence = by_radius + (radial[0] + m * velocity[0, 1]) / r + by_height
        assert_allclose(divergence, 0.0, atol=1e-8)


@pytest.mark.parametrize("m", range(LARGEST + 1))
def test_slopes_of_the_walls_flow(m: int) -> None:
    h, r, z = 1e-4, 0.9, 0.4
    places = np.array([z, z, z, z - h, z + h]), np.array([r, r - h, r + h, r, r])
    flow = Flow(places, m, 0.8)
    sums = flow.wall.of_resting_forces(grid().sources(m))
    velocity = flow.wall.velocity(sums)
    by_radius, by_height = flow.wall.gradient(sums)
    assert_allclose(by_radius[0], (velocity[2] - velocity[1]) / (2 * h), rtol=0, atol=1e-7)
    assert_allclose(by_height[0], (velocity[4] - velocity[3]) / (2 * h), rtol=0, atol=1e-7)


def test_flow_rate_by_reciprocity() -> None:
    # Through a section between the cells.
    nodes, weights = np.polynomial.legendre.leggauss(16)
    rho = 0.5 * RADIUS * (nodes + 1)
    section = np.pi * RADIUS * weights * rho / (np.pi * RADIUS**2)
    flow = Flow((np.full_like(rho, 0.5 * PERIOD), rho), 0, 0.0)
    z_source, rho_source = grid().places(cell())
    displaced = grid().sources(0)
    forces = unforced(0)
    change = flow_rate.extra_flux_change(
        grid().places(force())[0], rho_source, RADIUS, PERIOD, displaced, displaced @ forces
    )
    found = section @ flow.of_forces(forces)[:, 2]
    assert_allclose(found, change, rtol=0, atol=1e-10)
    assert np.abs(change).max() > 1e-3
    content = uninflated(0)
    area = grid().area_vectors(cell())
    flux = flow_rate.stress_flux(area, z_source, rho_source, RADIUS, PERIOD, displaced @ content)
    assert_allclose(section @ flow.of_stresses(content)[:, 2], flux, rtol=0, atol=1e-10)
    assert np.abs(flux).max() > 1e-3
    assert_allclose(section @ flow_rate.parabola(rho, RADIUS), 1.0, rtol=1e-14)


@pytest.mark.parametrize("phase", [0.0, 0.9])
def test_groups_of_waves_add_up_to_all(phase: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """In thin films the waves are too many to be held at once."""
    flow = Flow((np.array([-0.3, 0.5]), np.array([0.4, 1.1])), 1, phase)
    waves = flow.wall._waves
    assert waves.groups() == (waves,)
    monkeypatch.setattr(wall, "GROUP", wall.FIELDS * 8 * waves.rho.size * 7)
    groups = waves.groups()
    assert len(groups) > 2
    assert_allclose(np.concatenate([each.waves for each in groups]), waves.waves, atol=0)
    assert sum(each.uniform for each in groups) == int(waves.uniform)
    displaced, places = grid().sources(1), grid().places(force())
    whole, *parts = (
        each.velocity(each.of_forces(places, displaced, displaced))
        for each in (flow.wall, *(WallFlow(group, 1) for group in groups))
    )
    assert_allclose(sum(parts), whole, rtol=0, atol=1e-13 * np.abs(whole).max())
