"""Parts of one membrane that face each other: how far apart, whether they cross, their forces."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from numpy.polynomial import legendre
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial import cKDTree
from test_repulsion import RANGE, assert_gradient, of_spheres, sphere

from celltrain import Train
from celltrain.compiled.loops import CompiledLoop
from celltrain.evolution import Repulsion
from celltrain.evolution.films.forces import FilmForces
from celltrain.harmonics import (
    UNIT_DISPLACEMENT,
    coefficient_index,
    degrees_and_orders,
)
from celltrain.harmonics.grid import SphereGrid, sphere_grid
from celltrain.proximity import own_sides
from celltrain.proximity.film_points import film_grid
from celltrain.proximity.overlaps import overlaps
from celltrain.train import resting_shapes

DEGREE = 12
DISC_RADIUS = 1.3
ROD_RADIUS, ROD_LENGTH = 0.35, 4.0
# Rings of points that are many, and how long these surfaces are for one on the sphere.
DENSE, STRETCH = 180, 1.5


@pytest.fixture(scope="module")
def films() -> FilmForces:
    return of_spheres(DEGREE)


def hourglass(gap: float) -> np.ndarray:
    """A disc that is thinnest on its axis: z = x (gap/2 + 0.4 (1 - x^4)), x = cos(theta)."""
    shape = DISC_RADIUS * sphere(DEGREE)
    shape[2] = 0.0
    for n, each in enumerate(legendre.poly2leg([0.0, 0.5 * gap + 0.4, 0.0, 0.0, 0.0, -0.4])):
        shape[2, coefficient_index(n, 0)] = each * math.sqrt(4.0 * math.pi / (2 * n + 1))
    return shape


def sheared(gap: float) -> np.ndarray:
    """An hourglass with one face a step of the coarse grid beside the other."""
    shape = hourglass(gap)
    shape[0, coefficient_index(1, 0)] += 0.09
    return shape


def horn(gap: float) -> np.ndarray:
    """A rod with nearly flat ends, bent to a circle: its ends face each other, `gap` apart."""
    grid = film_grid(DEGREE).fine
    x, phi = np.cos(grid.angles[:, 0]), grid.angles[:, 1]
    width = ROD_RADIUS * np.sin(grid.angles[:, 0])
    middle = 0.5 * ROD_LENGTH / math.pi
    turn = (math.pi - 0.5 * gap / middle) * (1.5 * x - 0.5 * x**3)
    radius = middle + width * np.cos(phi)
    points = np.stack([radius * np.cos(turn), width * np.sin(phi), radius * np.sin(turn)])
    return np.asarray((points * grid.weights) @ grid.values)


def skewed(shape: np.ndarray) -> np.ndarray:
    """Moved, turned and deformed, so that nothing is symmetric."""
    change = np.random.default_rng(3).normal(size=shape.shape)
    degrees = degrees_and_orders(DEGREE)[0]
    turned = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
    turned *= np.sign(np.linalg.det(turned))
    moved = shape + 0.004 * np.where(degrees > 0, change / (1.0 + degrees) ** 2, 0.0)
    moved[:, 0] += np.array([0.2, -0.1, 0.4])
    return np.asarray(turned @ moved)


@pytest.fixture(scope="module")
def dense() -> SphereGrid:
    """A grid whose points are close to each other."""
    return sphere_grid(DEGREE, DENSE)


@pytest.mark.parametrize("form", [hourglass, sheared, horn])
@pytest.mark.parametrize(("gap", "within"), [(0.04, RANGE), (0.02, RANGE), (0.008, 0.0125)])
def test_distances_are_those_from_the_other_part(
    form: Any, gap: float, within: float, dense: SphereGrid
) -> None:
    shape = skewed(form(gap))
    grid = film_grid(DEGREE)
    shapes = shape[None]
    found = grid.find(shapes, grid.coarse.surfaces(shapes), within=within, period=math.inf)
    assert len(found.distance) > 50
    # The two parts are at the two poles of the parameters.
    front, there = (np.cos(each) > 0.0 for each in (grid.fine.angles[:, 0], dense.points()[0]))
    places, others = grid.fine.values @ shape.T, np.asarray(dense.values) @ shape.T
    near = np.zeros(0, dtype=int)
    for part in (True, False):
        here = np.flatnonzero(front == part)
        distance = cKDTree(others[there != part]).query(places[here])[0]
        listed = np.isin(found.node, here)
        sampled = distance[np.searchsorted(here, found.node[listed])]
        # From the nearest of the dense points, which are so far apart.
        assert (found.distance[listed] < sampled + 1e-12).all()
        assert (
            sampled < np.hypot(found.distance[listed], STRETCH * math.sqrt(0.5) * math.pi / DENSE)
        ).all()
        near = np.append(near, here[distance < 0.9 * within])
    # And none is missing; at the equator the two parts meet.
    near = near[np.abs(np.cos(grid.fine.angles[near, 0])) > 0.5]
    assert len(near) > 10
    assert np.isin(near, found.node).all()
    assert not overlaps(shape[None], period=math.inf)


def test_energy_of_a_thin_disc(films: FilmForces) -> None:
    gap = 0.03
    found = films(hourglass(gap)[None])
    # Distances of points of the upper face from the lower one, densely; by solid angle as areas.
    theta = np.linspace(1e-6, 0.5, 4001)
    x = np.cos(theta)
    z, r = x * (0.5 * gap + 0.4 * (1.0 - x**4)), DISC_RADIUS * np.sin(theta)
    distance = np.array([np.hypot(r - a, z + b).min() for a, b in zip(r[::8], z[::8], strict=True)])
    density = Repulsion(RANGE).energy_density(distance)
    one = np.trapezoid(2.0 * math.pi * np.sin(theta[::8]) * density, theta[::8])
    # Both faces, each counted half.
    assert_allclose(found.energy, one, rtol=0.05)


@pytest.mark.parametrize("form", [hourglass, horn])
def test_forces_are_the_gradient_of_the_energy_and_balanced(films: FilmForces, form: Any) -> None:
    shapes = skewed(form(0.025))[None]
    found = films(shapes)
    assert found.energy > 0.0
    assert_gradient(films, shapes)
    largest = np.abs(found.forces).max()
    assert_allclose(found.forces[0, :, 0], 0.0, atol=1e-13 * largest)
    torque = np.cross(shapes, found.forces, axis=1).sum(axis=(0, 2))
    assert_allclose(torque, 0.0, atol=1e-12 * largest)


@pytest.mark.parametrize("form", [hourglass, horn])
def test_parts_that_have_crossed(films: FilmForces, form: Any) -> None:
    shapes = skewed(form(-0.02))[None]
    found = films(shapes)
    assert found.gap < -0.005
    assert np.isnan(found.forces).all()
    (met,) = overlaps(shapes, period=math.inf)
    assert (met.first, met.second, met.image) == (0, 0, 0)
    assert str(met).startswith("two parts of cell 0 cross at x = ")


def test_nothing_beyond_the_range_and_nothing_on_cells_at_rest(films: FilmForces) -> None:
    for shape in (hourglass(0.06), horn(0.075), sphere(DEGREE)):
        found = films(skewed(shape)[None])
        assert found.gap == np.inf
        assert_array_equal(found.forces, 0.0)
    # Narrow, but no part of it faces another that closely.
    wide = dataclasses.replace(films, repulsion=Repulsion(0.2))
    assert wide(0.3 * sphere(DEGREE)[None]).gap == np.inf


def test_what_is_passed_by_could_not_be_found(
    films: FilmForces, monkeypatch: pytest.MonkeyPatch
) -> None:
    needle = np.array([[0.012], [0.012], [1.5]]) * sphere(DEGREE)
    forms = (
        skewed(hourglass(0.03)),
        skewed(horn(0.04)),
        needle,
        sheared(0.03),
        skewed(hourglass(0.3)),
    )
    shapes = np.stack(forms)
    shapes[:, 0, 0] += UNIT_DISPLACEMENT * 8.0 * np.arange(len(shapes))
    quick = films(shapes)

    def all_of_them(_: CompiledLoop, shape: tuple[int, ...], *__: np.ndarray) -> np.ndarray:
        return np.ones(shape)

    monkeypatch.setattr(own_sides, "call_on_host", all_of_them)
    whole = films(shapes)
    assert quick.gap == whole.gap
    assert_allclose(quick.energy, whole.energy, rtol=1e-13)
    assert_allclose(quick.forces, whole.forces, atol=1e-13 * np.abs(whole.forces).max())
    assert quick.forces[:-1].any(axis=(1, 2)).all()
    assert not quick.forces[-1].any()


def test_a_fold_of_thin_parts_has_not_crossed() -> None:
    # A sheet rolled up by a turn and a quarter: both parts of its film are thin.
    degree, thickness, gap = 16, 0.08, 0.06
    both = film_grid(degree)
    grid = both.fine
    x, sine, phi = np.cos(grid.angles[:, 0]), np.sin(grid.angles[:, 0]), grid.angles[:, 1]
    turn = 1.25 * math.pi * (1.5 * x - 0.5 * x**3)
    radius = 0.6 + (thickness + gap) * turn / (2.0 * math.pi) + 0.5 * thickness * sine * np.cos(phi)
    points = np.stack([radius * np.cos(turn), 0.5 * sine * np.sin(phi), radius * np.sin(turn)])
    shapes = np.asarray((points * grid.weights) @ grid.values)[None]
    found = both.find(shapes, both.coarse.surfaces(shapes), within=RANGE, period=math.inf)
    assert len(found.distance) > 1000
    assert (found.distance > 0.01).all()
    assert not overlaps(shapes, period=math.inf)


@pytest.mark.parametrize(
    "cell",
    [
        {},
        {"reduced_volume": 0.4},
        {"reference": "sphere"},
        {"reference": "spheroid", "aspect_ratio": 0.2},
    ],
)
def test_cells_at_rest_do_not_cross_themselves(cell: dict[str, Any]) -> None:
    train = Train(diameter=10, packing=0.2, cells=2, degree=DEGREE, **cell)
    assert not overlaps(resting_shapes(train, 2), period=train.length)
