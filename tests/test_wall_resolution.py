"""A simulation resolves the wall as finely as the cells' distance from it asks for."""

from dataclasses import replace
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain import Base, CaseError, Train
from celltrain.evolution import FromFile, Repulsion, StepFailed, evolve, resume
from celltrain.evolution.dynamics import train_dynamics
from celltrain.evolution.wall_resolution import LARGEST, SMALLEST, followed
from celltrain.flow import wall
from celltrain.flow.wall import _axial_response, _bessel_ratios
from celltrain.harmonics import UNIT_DISPLACEMENT
from celltrain.proximity.close_pairs import ClosePairs
from celltrain.proximity.distances import wall_distance
from celltrain.proximity.walls import RoundWall
from celltrain.train import resting_shapes, train_operator


def test_what_is_served_is_never_above_the_distance() -> None:
    served = LARGEST
    for distance in (2.0, 0.79, 0.41, 0.3, 0.15, 0.11):
        served = followed(served, distance)
        assert SMALLEST <= served <= distance
    assert served == SMALLEST
    # Back only well beyond the next one, so that no cell makes it change to and fro.
    assert followed(0.2, 0.59) == 0.2
    assert followed(0.2, 0.61) == 0.4
    assert followed(0.2, 3.0) == LARGEST


@pytest.mark.parametrize("distance", [0.09, -0.1, float("nan")])
def test_a_cell_at_the_wall_ends_a_simulation(distance: float) -> None:
    with pytest.raises(StepFailed, match="from the wall"):
        followed(LARGEST, distance)


def test_modes_of_any_order_are_finite_and_take_their_values_at_the_wall() -> None:
    # Bessel functions of order 400 at 0.6 are below the smallest number.
    waves = np.array([0.2, 20.0])
    for m in (0, 1, 90, 400):
        response = _axial_response(m, waves, 3.0, np.array([0.5, 1.0, 2.9, 3.0]))
        assert np.isfinite(response).all()
        assert_allclose(response[..., -1], np.broadcast_to(np.eye(3), (2, 3, 3)), atol=1e-8)
    # Either way to the ratios of Bessel functions gives the same.
    r, waves = np.array([0.3, 1.5, 3.0]), np.array([0.5, 2.0])
    direct = _bessel_ratios(60, waves, 3.0, r)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(wall, "LEAST_BESSEL", np.inf)
        assert_allclose(_bessel_ratios(60, waves, 3.0, r), direct, rtol=1e-11)


@pytest.mark.parametrize(("wall_gap", "many"), [(0.8, False), (0.4, True), (None, True)])
def test_pairs_close_to_the_wall_are_listed_where_cells_may_be(
    wall_gap: float | None, many: bool
) -> None:
    """At degree 12 a cell is close to what is less than 0.44 r0 from it; this is 0.1."""
    train = Train(diameter=4.6, packing=0.2, degree=12)
    operator = train_operator(train, wall_gap=wall_gap)
    shapes = resting_shapes(train, 1)
    distance = float(wall_distance(shapes, RoundWall(train.radius))[0])
    shapes[:, 0, 0] += (distance - 0.1) * UNIT_DISPLACEMENT

    @jax.jit
    def pairs(shapes: jax.Array) -> ClosePairs:
        points = operator.source_points(shapes)
        found = operator.flow.close_targets(operator.targets(shapes), jnp.arange(1), points)
        assert found is not None
        return found[1].pairs

    found = pairs(shapes)
    assert found.count > 64
    assert found.overflow == (not many)


@pytest.fixture(scope="module")
def single(coarse_base: Base) -> Base:
    return replace(coarse_base, train=coarse_base.train.changed(cells=1))


def moved_to(distance: float, base: Base, path: Path) -> FromFile:
    """The steady train's cell moved sideways, to a distance from the wall."""
    change = np.zeros((1, *base.coefficients.shape))
    dynamics = train_dynamics(base, Repulsion(), wall_gap=LARGEST)
    aside = dynamics.wall_distance(np.asarray(dynamics.base)) - distance
    change[0, 0, 0] = aside * UNIT_DISPLACEMENT
    np.save(path, change)
    return FromFile(path)


@pytest.mark.slow
def test_a_cell_near_the_wall_refines_it(single: Base, tmp_path: Path) -> None:
    disturbance = moved_to(0.35, single, tmp_path / "moved.npy")
    path = tmp_path / "run.nc"
    run = evolve(single, disturbance, degree=6, until=1.0, most_steps=1, path=path)
    assert run.state.wall_gap == 0.2
    assert run.frames["wall_distance"][0] == pytest.approx(0.35, abs=0.02)
    assert resume(path, most_steps=1).state.wall_gap == 0.2
    # Refined further nothing changes; a wall for cells on the axis gives something else.
    shapes = run.shapes[0]
    served, finer, coarse = (
        train_dynamics(single, Repulsion(), wall_gap=gap).rates(shapes) for gap in (0.2, 0.15, 1.6)
    )
    size = np.linalg.norm(finer)
    assert np.linalg.norm(served - finer) < 1e-6 * size
    assert np.linalg.norm(coarse - finer) > 1e-5 * size


def test_a_disturbance_that_touches_the_wall_is_refused(single: Base, tmp_path: Path) -> None:
    with pytest.raises((CaseError, StepFailed), match="wall"):
        evolve(single, moved_to(0.05, single, tmp_path / "moved.npy"), degree=6, until=1.0)
