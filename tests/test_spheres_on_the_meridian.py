"""Rigid spheres on the axis of a tube, from the single layer on the meridian.

The axisymmetric forces that give all points of a sphere the same velocity, K1 of a sphere that is
driven through fluid without mean flow and K2 of one that is held in the flow, both over Stokes'
drag (the flow's at its speed on the axis), against series solutions.
"""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain import Train
from celltrain.harmonics import UNIT_DISPLACEMENT
from celltrain.meridian import flow_rate
from celltrain.meridian.grids import HalfCircle
from celltrain.meridian.images import force_image
from celltrain.meridian.moments import SINGLE, member_matrix
from celltrain.meridian.tail import Tail
from celltrain.meridian.train import TrainFlow
from celltrain.meridian.wall import WallFlow, WallWaves
from celltrain.steady.problem import SteadyProblem

DEGREE = 16
#: From the member that moves a cell to a unit of velocity, and to the net force.


@dataclass(frozen=True)
class Sphere:
    """Forces by members of m = 0, and what they do."""

    flow: TrainFlow
    moving: np.ndarray
    held: np.ndarray

    @property
    def drag_moving(self) -> float:
        return float(self.moving[0]) * UNIT_DISPLACEMENT / (6 * np.pi)

    @property
    def drag_held(self) -> float:
        return -float(self.held[0]) * UNIT_DISPLACEMENT / (12 * np.pi)

    @property
    def free_velocity(self) -> float:
        return -float(self.held[0] / self.moving[0])

    @property
    def apparent_viscosity(self) -> float:
        return 1.0 - float(extra_flux(self.flow) @ (self.free_velocity * self.moving + self.held))


def extra_flux(flow: TrainFlow) -> np.ndarray:
    forces = flow.sources.sources(0)
    none = np.zeros(flow.sources.size)
    rho, still = flow.source_places[1], np.zeros_like(forces)
    return flow_rate.extra_flux_change(none, rho, flow.radius, flow.period, still, forces)


def velocity_by_forces(flow: TrainFlow) -> np.ndarray:
    """At the targets, without mean flow and before the flow rate is held, [target, 3, member].

    The sum over images of a net force has no limit, but for a uniform velocity along the tube,
    which a point on the wall tells: there nothing moves.
    """
    grid, forces = flow.sources, flow.sources.sources(0)
    (z, rho), on_wall = flow.source_places, (np.zeros(1), np.full(1, flow.radius))
    z_target, rho_target = (np.concatenate(pair) for pair in zip(flow.places, on_wall, strict=True))
    tail = Tail(
        period=flow.period,
        nearest=0,
        distance=flow.period - float(np.ptp(z)),
        smallest_phase=0.5,
        tolerance=flow.rules.tolerance,
        sources=(z, rho),
        targets=(z_target, rho_target),
        orders=3,
    )
    waves = WallWaves(
        phase=0.0,
        radius=flow.radius,
        period=flow.period,
        wall_distance=0.5 * flow.wall_distance,
        tolerance=flow.rules.tolerance,
        rho=np.concatenate([rho, rho_target]),
        z=np.concatenate([z, z_target]),
        sources=grid.size,
        orders=3,
    )
    wall = WallFlow(waves, 0)
    circle = HalfCircle(2 * grid.size)
    image = force_image(grid, circle, on_wall, flow.profile, flow.force, 0.0, 2)
    own = [member_matrix(each.at, SINGLE, 0) for each in (flow.own, image)]
    far = tail.velocity(0, 0.0, tail.of_resting_forces(0, forces))
    found = np.concatenate(own) + far + wall.velocity(wall.of_resting_forces(forces))
    slip = found[-1].real.copy()
    uniform = slip[2, 0]
    slip[2, 0] = 0.0
    assert_allclose(slip, 0.0, atol=1e-11)
    velocity = found[:-1].real
    velocity[:, 2, 0] -= uniform
    return velocity


def sphere(size: float, period: float, degree: int = DEGREE) -> Sphere:
    """Of a radius and in a period that are given over the tube's radius."""
    train = Train(
        diameter=2 / size, packing=size / period, cells=1, reference="sphere", degree=degree
    )
    problem = SteadyProblem(train)
    rules = replace(problem.rules(problem.rest), tolerance=1e-12)
    rules = replace(rules, sources=max(60, 2 * rules.sources), radial=60, half_circle=40)
    flow = TrainFlow(
        problem.membrane, problem.rest, radius=train.radius, period=train.period, rules=rules
    )
    velocity = velocity_by_forces(flow)
    parabola = flow_rate.parabola(flow.places[1], flow.radius)
    velocity[:, 2] -= np.outer(parabola, extra_flux(flow))
    project = flow.targets.projection(0)
    mobility = project @ velocity.reshape(-1, velocity.shape[-1])
    upward = np.eye(len(mobility))[0] * UNIT_DISPLACEMENT
    driven = np.zeros((len(parabola), 3))
    driven[:, 2] = parabola
    columns = np.stack([upward, -(project @ driven.ravel())], axis=1)
    # A uniform pressure moves nothing: least squares leaves it out.
    moving, held = np.linalg.lstsq(mobility, columns, rcond=1e-9)[0].T
    return Sphere(flow, moving, held)


@pytest.mark.parametrize(
    ("size", "moving", "held"),
    [(0.3, 2.370094890, 2.228976606), (0.5, 5.947374246, 4.995338624)],
)
def test_drag_by_series(size: float, moving: float, held: float) -> None:
    found = sphere(size, 10.0)
    assert_allclose([found.drag_moving, found.drag_held], [moving, held], rtol=3e-10)


@pytest.mark.parametrize(
    ("size", "moving", "held"),
    [
        (0.1, 1.263213910, 1.254794546),
        (0.2, 1.679478883, 1.634786392),
        (0.4, 3.591373268, 3.215736616),
        (0.6, 11.091896773, 8.613007137),
        (0.7, 24.675983776, 17.474034219),
        (0.8, 74.669965738, 47.620234543),
    ],
)
def test_drag_by_the_operator_for_any_shapes(size: float, moving: float, held: float) -> None:
    # As far as its sums go: a few 1e-9, near the wall 1e-8.
    found = sphere(size, 10.0)
    bound = 5e-9 if size < 0.75 else 2e-8
    assert_allclose([found.drag_moving, found.drag_held], [moving, held], rtol=bound)


def test_drag_in_longer_tubes_and_at_another_degree() -> None:
    found, longer = (sphere(0.2, period) for period in (10.0, 16.0))
    other = sphere(0.2, 10.0, degree=8)
    assert_allclose([longer.drag_moving, longer.drag_held], [1.67947888485, 1.63478639325], 1e-11)
    for each in (found, other):
        drags = [each.drag_moving, each.drag_held]
        assert_allclose(drags, [longer.drag_moving, longer.drag_held], rtol=1e-11)


def test_train_of_free_spheres() -> None:
    found = sphere(0.5, 2.0)
    assert_allclose(found.free_velocity, 1.678961846, rtol=1e-9)
    assert_allclose(found.apparent_viscosity, 1.032347094, rtol=1e-9)
