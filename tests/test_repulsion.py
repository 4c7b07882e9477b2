"""The short-range repulsion: its potential, films and their forces, simulations with it."""

import dataclasses
import json
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from same_runs import assert_same_place
from scipy.spatial import cKDTree

from celltrain import Base, CaseError, Train, save
from celltrain.cli import main
from celltrain.evolution import (
    ForwardEuler,
    FromFile,
    RandomDisplacement,
    Repulsion,
    Run,
    StepFailed,
    evolve,
    resume,
)
from celltrain.evolution.dynamics import Dynamics, train_dynamics
from celltrain.evolution.films.forces import FilmForces, film_forces
from celltrain.evolution.methods.chebyshev import chebyshev_step
from celltrain.evolution.methods.control import GAP_SHARE
from celltrain.evolution.record.repulsion import repulsion_record
from celltrain.harmonics import UNIT_DISPLACEMENT, degrees_and_orders
from celltrain.harmonics.grid import sphere_grid
from celltrain.harmonics.rotation import pole_rotation
from celltrain.proximity.distances import cell_distance
from celltrain.surroundings import RoundTube

DEGREE = 6
FAR = 40.0
RANGE = 0.05
# Force that pushes one cell towards another, mu U r0.
PUSH = 20.0


def sphere(degree: int) -> np.ndarray:
    """The unit sphere, [3, coefficient]."""
    shape = np.zeros((3, degree**2))
    shape[0, 3] = shape[1, 1] = shape[2, 2] = np.sqrt(4.0 * np.pi / 3.0)
    return shape


def placed(shape: np.ndarray, *places: tuple[float, float, float]) -> np.ndarray:
    """Copies of a shape with their centres there."""
    shapes = np.repeat(shape[None], len(places), axis=0)
    shapes[:, :, 0] += UNIT_DISPLACEMENT * np.array(places)
    return shapes


def of_spheres(degree: int, *, length: float = FAR, radius: float = FAR) -> FilmForces:
    """Films of unit spheres."""
    train = Train(diameter=6, packing=0.2, cells=2, degree=degree)
    made = film_forces(train.cell, train.sizes, RoundTube(radius, length), Repulsion(RANGE))
    return dataclasses.replace(made, at_rest=sphere(degree))


@pytest.fixture(scope="module")
def films() -> FilmForces:
    return of_spheres(DEGREE)


def test_potential() -> None:
    repulsion = Repulsion(0.04, 0.3)
    gap = np.linspace(0.004, 0.0399, 50)
    step = 1e-7
    slope = repulsion.energy_density(gap + step) - repulsion.energy_density(gap - step)
    assert_allclose(-slope / (2 * step), repulsion.pressure(gap), rtol=1e-6, atol=1e-9)
    assert_array_equal(repulsion.energy_density(np.array([0.04, 0.05, 3.0])), 0.0)
    assert_array_equal(repulsion.pressure(np.array([0.04, 0.05, 3.0])), 0.0)
    assert np.all(np.diff(repulsion.pressure(gap)) < 0.0)
    # Half way: S/a (1/2)^2 2/(1/4).
    assert_allclose(repulsion.pressure(np.array([0.02])), 0.3 / 0.04 * 2.0, rtol=1e-14)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"range": -0.01}, r"range = -0\.01 .* 0 \(none\) to 0\.2"),
        ({"range": 0.3}, r"range = 0\.3"),
        ({"range": float("nan")}, "range = nan"),
        ({"strength": 0.0}, r"strength = 0\.0 .* > 0"),
        ({"strength": float("inf")}, "strength = inf"),
    ],
)
def test_settings_that_are_refused(settings: dict[str, float], message: str) -> None:
    with pytest.raises(CaseError, match=message):
        Repulsion(**settings)


@pytest.mark.parametrize("gap", [0.04, 0.02, 0.01])
def test_energy_and_force_between_spheres(gap: float) -> None:
    found = of_spheres(12)(placed(sphere(12), (0.1, 0.0, 0.0), (0.1, 0.0, 2.0 + gap)))
    # The distance of a point at the angle t from the line of centres, to the other sphere.
    t = np.linspace(0.0, 0.4, 40001)
    apart = 2.0 + gap
    distance = np.sqrt(1.0 + apart**2 - 2.0 * apart * np.cos(t)) - 1.0
    repulsion = Repulsion(RANGE)
    energy = np.trapezoid(2.0 * np.pi * np.sin(t) * repulsion.energy_density(distance), t)
    across = (apart - np.cos(t)) / (distance + 1.0)
    force = np.trapezoid(2.0 * np.pi * np.sin(t) * repulsion.pressure(distance) * across, t)
    assert_allclose(found.energy, energy, rtol=0.03)
    total = found.forces[:, :, 0] * UNIT_DISPLACEMENT
    assert_allclose(total[:, 2], [-force, force], rtol=0.03)
    assert_allclose(total[:, :2], 0.0, atol=1e-3 * force)
    assert gap <= found.gap < gap + 0.002


def skewed(seed: int) -> np.ndarray:
    """Three deformed spheres: the first close to the second and to the third's image."""
    shapes = placed(sphere(DEGREE), (0.2, 0.0, 0.0), (0.0, 0.1, 2.0), (0.0, 0.0, 5.0))
    change = np.random.default_rng(seed).normal(size=shapes.shape)
    degrees = degrees_and_orders(DEGREE)[0]
    return shapes + 0.02 * np.where(degrees > 0, change / (1.0 + degrees) ** 2, 0.0)


def with_gap(films: FilmForces, shapes: np.ndarray, gap: float) -> np.ndarray:
    """The second cell moved along the tube, from where it is, to a distance from the first."""
    wide = dataclasses.replace(films, repulsion=Repulsion(0.2))
    moved, (near, far) = shapes.copy(), (0.5, 3.0)
    while far - near > 1e-7:
        middle = 0.5 * (near + far)
        moved[1, 2, 0] = shapes[0, 2, 0] + UNIT_DISPLACEMENT * middle
        near, far = (middle, far) if wide(moved).gap < gap else (near, middle)
    return moved


def assert_gradient(films: FilmForces, shapes: np.ndarray) -> None:
    """The forces are minus the gradient of the energy."""
    forces, step = films(shapes).forces, 1e-6
    for seed in range(3):
        change = np.random.default_rng(seed).normal(size=shapes.shape)
        ahead, behind = (films(shapes + h * change).energy for h in (step, -step))
        assert_allclose(
            (ahead - behind) / (2 * step), -np.sum(forces * change), rtol=2e-4, atol=1e-8
        )


@pytest.mark.parametrize("case", ["cells", "image", "own image", "wall"])
def test_force_is_minus_the_gradient_of_the_energy(case: str) -> None:
    films = of_spheres(
        DEGREE,
        length={"image": 7.02, "own image": 2.02}.get(case, FAR),
        radius=1.22 if case == "wall" else FAR,
    )
    shapes = with_gap(films, skewed(0), 0.02) if case == "cells" else skewed(0)
    if case in ("own image", "wall"):
        shapes = shapes[:1]
    if case == "image":
        shapes[1, 0, 0] += 3.0 * UNIT_DISPLACEMENT
    found = films(shapes)
    assert 0.0 < found.gap < RANGE
    assert found.energy > 0.0
    assert found.force > 0.0
    assert_gradient(films, shapes)
    if case != "wall":
        total = found.forces[:, :, 0].sum(axis=0)
        assert_allclose(total, 0.0, atol=1e-13 * np.abs(found.forces).max())


@pytest.mark.parametrize("nested", [True, False])
def test_no_point_of_a_film_is_missed(films: FilmForces, nested: bool) -> None:
    """Of cells within each other, so that points are near all others and images, and beside."""
    if nested:
        period, shapes = 2.02, skewed(3)[:1] * np.array([1.0, 1.02, 1.05])[:, None, None]
    else:
        period, shapes = 7.02, with_gap(films, skewed(3), 0.01)
    # The same surfaces by other parameters: points do not lie on top of each other.
    angles = jnp.array([0.0, 0.7, 2.0]), jnp.array([0.0, 1.0, -0.5])
    shapes = np.asarray(pole_rotation(DEGREE).to_pole(jnp.asarray(shapes), *angles))
    grid, dense = films.grid, sphere_grid(DEGREE, 180)
    found = grid.find(shapes, grid.coarse.surfaces(shapes), within=RANGE, period=period)
    assert len(found.node) > (4 * len(grid.fine.angles) if nested else 20)
    # A cell's own image counts as itself.
    listed: dict[tuple[int, int], set[int]] = {
        (cell, other): set() for cell in range(3) for other in range(3)
    }
    for cell, other, node in zip(found.cell, found.other, found.node, strict=True):
        listed[cell, other].add(node)
    images = np.array([[0.0, 0.0, period * image] for image in (-1, 0, 1)])
    for other in range(3):
        points = np.asarray(dense.values) @ shapes[other].T
        for cell in range(3):
            # A cell's own points are at no distance from itself.
            shifts = images[[0, 2]] if cell == other else images
            tree = cKDTree(np.concatenate([points + shift for shift in shifts]))
            distance = tree.query(grid.fine.values @ shapes[cell].T)[0]
            near = np.flatnonzero(distance < 0.98 * RANGE)
            assert listed[cell, other].issuperset(near)
            facing = nested or {cell, other} in ({0, 1}, {0, 2})
            assert len(near) >= (5 if facing else 0)


def test_no_torque_between_cells(films: FilmForces) -> None:
    shapes = with_gap(films, skewed(1), 0.015)
    forces = films(shapes).forces
    assert np.abs(forces[2]).max() == 0.0
    torque = np.cross(shapes, forces, axis=1).sum(axis=(0, 2))
    assert_allclose(torque, 0.0, atol=1e-13 * np.abs(forces).max())


def test_nothing_beyond_the_range(films: FilmForces) -> None:
    shapes = with_gap(films, skewed(2), 1.001 * RANGE)
    found = films(shapes)
    assert found.gap == np.inf
    assert found.energy == found.force == 0.0
    assert_array_equal(found.forces, 0.0)
    none = dataclasses.replace(films, repulsion=Repulsion(0.0))
    assert none(with_gap(films, skewed(2), 0.01)).gap == np.inf


def test_cells_that_cross_have_no_force(films: FilmForces) -> None:
    crossing = placed(sphere(DEGREE), (0.0, 0.0, 0.0), (0.0, 0.0, 1.99))
    found = films(crossing)
    assert found.gap < 0.0
    assert np.isnan(found.forces).all()
    narrow = RoundTube(0.99, films.surroundings.period)
    beyond = dataclasses.replace(films, surroundings=narrow)(crossing[:1])
    assert_allclose(beyond.gap, -0.01, atol=1e-3)


@pytest.fixture(scope="module")
def close(coarse_base: Base) -> Base:
    """Two of the steady train's cells in a wide tube: nothing steady, but a start."""
    train = coarse_base.train.changed(cells=2, diameter=10, source_order=16, tolerance=1e-5)
    return dataclasses.replace(coarse_base, train=train)


@pytest.fixture(scope="module")
def dynamics(close: Base) -> Dynamics:
    return train_dynamics(close, Repulsion(), wall_gap=0.8)


def side_by_side(dynamics: Dynamics, gap: float) -> np.ndarray:
    """The two cells beside each other on either side of the axis."""
    wide = dataclasses.replace(dynamics.film_forces, repulsion=Repulsion(0.2))
    shapes, (near, far) = np.array(dynamics.base), (1.0, 1.5)
    shapes[:, 2, 0] = 0.0
    while far - near > 1e-7:
        middle = 0.5 * (near + far)
        shapes[:, 0, 0] = UNIT_DISPLACEMENT * np.array([-middle, middle])
        near, far = (middle, far) if wide(shapes).gap < gap else (near, middle)
    return shapes


def test_distance_of_membranes_along_each_other(dynamics: Dynamics) -> None:
    # A nose in the next cell's hollow: close all around, and closest between points of the grid.
    shapes = np.array(dynamics.base)
    shapes[1, 0, 0] += 0.1 * UNIT_DISPLACEMENT
    for gap in (0.02, 0.05):
        nested = with_gap(dynamics.film_forces, shapes, gap)
        found = cell_distance(nested, dynamics.surroundings.period)
        assert_allclose(found, gap, rtol=0, atol=1e-3)


def test_membranes_and_films_lose_energy_without_flow(dynamics: Dynamics) -> None:
    shapes = side_by_side(dynamics, 0.004)
    films = dynamics.film_forces(shapes)
    elastic = np.asarray(dynamics.operator.forces(jnp.asarray(shapes)))
    # Velocity by the forces alone, and by those of the films alone.
    still = dynamics.forced_rates(shapes, -elastic)
    response = dynamics.rates(shapes) - still
    by_films = dynamics.forced_rates(shapes, films.forces - elastic) - still
    forces = elastic + films.forces
    assert np.sum(forces * response) > 0.05 * np.linalg.norm(forces) * np.linalg.norm(response)
    assert np.sum(films.forces * by_films) > 0.0


def test_cells_pushed_together_keep_apart(dynamics: Dynamics) -> None:
    start = side_by_side(dynamics, 0.008)
    push = np.zeros_like(start)
    push[:, 0, 0] = np.array([PUSH, -PUSH]) / UNIT_DISPLACEMENT

    def gaps(films: FilmForces) -> list[float]:
        def rates(shapes: np.ndarray) -> np.ndarray:
            return dynamics.forced_rates(shapes, films(shapes).forces + push)

        shapes, found = start, []
        for _ in range(4):
            shapes = chebyshev_step(rates, shapes, rates(shapes), 0.15, 6)
            found.append(dynamics.film_forces(shapes).gap)
        return found

    assert min(gaps(dynamics.film_forces)) > 0.005
    # Their harmonics alone do not keep cells apart.
    assert min(gaps(dataclasses.replace(dynamics.film_forces, repulsion=Repulsion(0.0)))) < 0.0


def test_within_the_range_a_step_errs_by_part_of_the_gap_and_runs_go_on_bit_for_bit(
    close: Base, dynamics: Dynamics, tmp_path: Path
) -> None:
    start, path = tmp_path / "start.npy", tmp_path / "run.nc"
    np.save(start, side_by_side(dynamics, 0.006) - np.asarray(dynamics.base))
    settings = {"degree": 6, "until": 5.0, "every": 5.0, "repulsion": Repulsion(0.02, 0.05)}
    whole = evolve(close, FromFile(start), most_steps=4, **settings)
    evolve(close, FromFile(start), most_steps=2, path=path, **settings)
    again = resume(path, most_steps=2)
    assert Run.load(path).repulsion == again.repulsion == Repulsion(0.02, 0.05)
    assert_same_place(whole, again)
    for name in whole.history.keys() - {"wall_seconds"}:
        assert_array_equal(whole.history[name], again.history[name], err_msg=name)
    history = whole.history
    assert np.all(history["gap"] < 0.02)
    assert np.all(history["film_energy"] > 0.0)
    assert np.all(history["error"][1:] <= GAP_SHARE * history["gap"][:-1])
    # What is called the energy is that of the membranes.
    elastic = sum(whole.frames[f"energy_{part}"] for part in ("shear", "dilatation", "bending"))
    assert_allclose(history["energy"][0], elastic[0].sum(), rtol=1e-10)
    record = repulsion_record(whole)
    assert whole.repulsion.range == 0.02
    assert record["since"] == 0.0
    assert record["duration"] == pytest.approx(whole.state.time)
    assert record["smallest_gap"] == history["gap"].min()


def test_a_steady_train_within_the_range_is_refused(close: Base) -> None:
    # Bullets nest in each other at this packing.
    crowded = dataclasses.replace(close, train=close.train.changed(packing=0.92))
    with pytest.raises(CaseError, match=r"repulsion_range = 0\.2 .* has a gap of"):
        evolve(crowded, RandomDisplacement(1e-3), degree=6, until=1.0, repulsion=Repulsion(0.2))


def test_a_long_euler_step_across_a_film_is_an_overlap(close: Base, dynamics: Dynamics) -> None:
    state, method = dynamics.state(0.0, side_by_side(dynamics, 0.02)), ForwardEuler(1.0)
    closing = np.zeros_like(state.rates)
    closing[:, 0, 0] = UNIT_DISPLACEMENT * np.array([0.1, -0.1])
    with pytest.raises(StepFailed, match="membranes cross") as failure:
        method.advance(dynamics, dataclasses.replace(state, rates=closing), method.begin(state))
    assert failure.value.kind == "overlap"


def test_the_command_takes_and_reports_the_repulsion(
    close: Base, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    start, path = tmp_path / "start.nc", tmp_path / "run.nc"
    save(close, start)
    arguments = [
        "evolve",
        str(start),
        "--degree",
        "6",
        "--disturbance",
        "random",
        "--amplitude",
        "0.01",
    ]
    arguments += ["--until", "0.02", "-o", str(path), "--quiet", "--json"]
    assert main([*arguments, "--repulsion-range", "0.5"]) == 2
    assert "repulsion_range = 0.5 is not allowed" in capsys.readouterr().err
    assert not path.exists()
    assert main([*arguments, "--repulsion-range", "0.03", "--repulsion-strength", "0.2"]) == 0
    record = json.loads(capsys.readouterr().out)["repulsion"]
    assert (record["range"], record["strength"]) == (0.03, 0.2)
    assert record["since"] is record["smallest_gap"] is None
    assert main(["evolve", "--resume", "-o", str(path), "--quiet"]) == 0
    assert "never within 0.03" in capsys.readouterr().out
