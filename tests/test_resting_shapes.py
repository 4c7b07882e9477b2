"""Shapes at rest: the family of reduced volumes, spheroids, and shapes from points."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain import CaseError, NotConverged, Train, stability, steady
from celltrain.harmonics import coefficients_of, profile_of
from celltrain.membrane import meridian_membrane, reference_coefficients, resting_shape
from celltrain.membrane.equilibrium import relaxed_shape, relaxed_slope
from celltrain.membrane.relaxation import REPULSION_RANGE, relaxation
from celltrain.meridian.geometry import meridian_points, size_at_rest
from celltrain.meridian.grids import meridian_grid
from celltrain.parameters import Cell, merge_case
from celltrain.parameters.profile import enclosed
from celltrain.steady.problem import SteadyProblem

DEGREE = 8
CUP_POINTS = 60


def area_and_volume(shape: np.ndarray) -> tuple[float, float]:
    """From the vectors n dS/dOmega, by rules other than those of the minimisation."""
    profile = profile_of(shape)
    grid = meridian_grid(profile.shape[1], 48)
    vectors, places = grid.area_vectors(profile), grid.places(profile)
    weights = 2.0 * np.pi * grid.weights
    volume = weights @ sum(a * b for a, b in zip(vectors, places, strict=True)) / 3.0
    return float(weights @ np.hypot(*vectors)), float(volume)


def places(shape: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distance from the axis and height along the meridian."""
    return meridian_points(profile_of(shape))


def reduced(shape: np.ndarray) -> float:
    area, volume = area_and_volume(shape)
    return 6.0 * np.sqrt(np.pi) * volume / area**1.5


def cup() -> np.ndarray:
    """Points of a stomatocyte: a shell of two spherical caps with a round rim."""
    angle = np.linspace(0.0, 1.0, CUP_POINTS)
    theta = np.pi * angle
    radius = 1.2 * np.sin(theta)
    return np.stack([radius, 0.45 * np.cos(theta) - 0.35 * radius**2 + 0.3], axis=1)


@pytest.mark.parametrize("v", [0.4, 0.55, 0.61, 0.8, 0.95])
def test_area_is_the_healthy_cells_and_volume_is_v(v: float) -> None:
    area, _ = area_and_volume(reference_coefficients(DEGREE, "biconcave"))
    shape = relaxed_shape(DEGREE, v)
    found, volume = area_and_volume(shape)
    assert_allclose(found, area, rtol=1e-8)
    assert_allclose(volume, v * 4 / 3 * np.pi * (area / (4 * np.pi)) ** 1.5, rtol=1e-8)


@pytest.mark.parametrize("v", [0.4, 0.55, 0.8, 0.95])
def test_no_other_shape_nearby_has_less_energy(v: float) -> None:
    problem = relaxation(DEGREE)
    unknowns = problem.unknowns(profile_of(relaxed_shape(DEGREE, v)))
    shape = coefficients_of(problem.profile(unknowns))
    assert_allclose(shape, relaxed_shape(DEGREE, v), atol=1e-14)
    here = problem.derivatives(unknowns)
    assert np.abs(here.imbalance).max() < 1e-9
    # Displacements, brought back to the same area and volume by Newton's method.
    least, target = problem.energy(unknowns), problem.held(unknowns)
    inverse = np.linalg.pinv(here.normals)
    random = np.random.default_rng(0)
    for _ in range(5):
        moved = unknowns + 0.02 * random.normal(size=unknowns.size)
        for _ in range(8):
            moved = moved - inverse @ (problem.held(moved) - target)
        assert_allclose(problem.held(moved), target, rtol=1e-6)
        assert problem.energy(moved) > least + 1e-4


# With and without the repulsion.
@pytest.mark.parametrize("v", [0.5, 0.8])
def test_derivatives_of_what_is_least_and_held(v: float) -> None:
    problem = relaxation(DEGREE)
    unknowns = problem.unknowns(profile_of(relaxed_shape(DEGREE, v)))
    random = np.random.default_rng(1)
    unknowns = unknowns + 0.003 * random.normal(size=unknowns.size)
    step = 1e-5 * random.normal(size=unknowns.size)
    here, ahead, behind = (problem.derivatives(unknowns + s * step) for s in (0, 1, -1))
    change = problem.energy(unknowns + step) - problem.energy(unknowns - step)
    assert change == pytest.approx(2 * here.gradient @ step, rel=1e-5)
    changes = problem.held(unknowns + step) - problem.held(unknowns - step)
    assert_allclose(changes, 2 * here.normals @ step, rtol=1e-6)
    size = np.abs(here.hessian @ step).max()
    change = ahead.gradient - behind.gradient
    assert_allclose(change, 2 * here.hessian @ step, rtol=0, atol=1e-4 * size)
    assert_allclose(ahead.normals - behind.normals, 2 * here.bends @ step, rtol=0, atol=1e-9)


@pytest.mark.parametrize("v", [0.5, 0.8])
def test_slope_of_a_shape(v: float) -> None:
    change = relaxed_shape(DEGREE, v + 1e-4) - relaxed_shape(DEGREE, v - 1e-4)
    slope = relaxed_slope(DEGREE, v)
    assert np.abs(slope).max() > 1.0
    assert_allclose(change / 2e-4, slope, rtol=0, atol=1e-4)


def test_the_healthy_cell_is_a_member_and_the_sphere_another() -> None:
    healthy = reference_coefficients(DEGREE, "biconcave")
    v = reduced(healthy)
    assert v == pytest.approx(0.6444, abs=5e-5)
    # It is free of stress, so nothing relaxes.
    assert_allclose(relaxed_shape(DEGREE, v), healthy, rtol=0, atol=1e-7)
    area, _ = area_and_volume(healthy)
    ball = relaxed_shape(DEGREE, 1.0)
    assert_allclose(ball, np.sqrt(area / (4 * np.pi)) * reference_coefficients(DEGREE, "sphere"))
    # Towards it the shapes tend like the square root of what is missing.
    radii = [places(relaxed_shape(12, 1 - each))[0].max() for each in (1e-2, 1e-4)]
    missing = np.array(radii) - places(ball)[0].max()
    assert missing[0] / missing[1] == pytest.approx(10, rel=0.2)


@pytest.mark.parametrize("v", [0.4, 0.5, 0.6])
def test_faces_of_a_thin_cell_stay_apart(v: float) -> None:
    problem = relaxation(DEGREE)
    shape = relaxed_shape(DEGREE, v)
    least = problem.least_thickness(problem.unknowns(profile_of(shape)))
    assert 0.5 * REPULSION_RANGE < least < REPULSION_RANGE
    rho, z = places(shape)
    assert (z[1:1000] > 0.0).all()
    assert (np.diff(rho)[:1000] > -1e-12).all()


def test_wrong_shapes_are_refused(tmp_path: Path) -> None:
    case = {"diameter": 8.0, "packing": 0.2}
    for leaves, words in (
        ({"reduced_volume": 0.3}, r"reduced_volume = 0.3 is not allowed; allowed: .*0.4 to 1"),
        ({"reduced_volume": 0.8, "reference": "sphere"}, "with reference = 'sphere'"),
        ({"aspect_ratio": 0.5}, "aspect_ratio = 0.5 .* with reference = 'spheroid'"),
        ({"reference": "spheroid"}, "needs aspect_ratio"),
        ({"reference": "profile"}, "needs profile"),
        ({"reference": "profile", "profile": "nowhere.csv"}, "cannot be read"),
        ({"reference": "profile", "profile": [[0, 1], [1, 0], [0, -1]]}, "3 points"),
        ({"reference": "profile", "profile": cup()[1:].tolist()}, "on the axis"),
        ({"reference": "profile", "profile": crossing().tolist()}, "crosses itself"),
    ):
        with pytest.raises(CaseError, match=words):
            Train(**case, **leaves)
    words = tmp_path / "words.csv"
    words.write_text("rho, z\n0, 1\n")
    with pytest.raises(CaseError, match="two numbers"):
        Train(**case, reference="profile", profile=str(words))


def crossing() -> np.ndarray:
    points = cup()
    points[10:30] = points[10:30][::-1]
    return points


def test_a_spheroid_has_the_healthy_cells_volume() -> None:
    cell = Cell(reference="spheroid", aspect_ratio=0.5)
    shape = resting_shape(cell, DEGREE)
    assert area_and_volume(shape)[1] == pytest.approx(4 / 3 * np.pi, rel=1e-12)
    diameter, thickness = size_at_rest(profile_of(shape))
    assert thickness / diameter == pytest.approx(0.5, rel=1e-4)


def test_a_shape_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "cup.csv"
    # From the lower pole to the upper one is as good.
    np.savetxt(path, cup()[::-1], delimiter=",", header="distance from the axis, height")
    train = Train(diameter=8, packing=0.2, reference="profile", profile=str(path), degree=12)
    shape = resting_shape(train.cell, 12)
    rho, z = places(shape)
    distance = np.hypot(rho[:, None] - cup()[:, 0], z[:, None] - (cup()[:, 1] - mean_height(shape)))
    assert distance.min(axis=0).max() < 0.03
    assert area_and_volume(shape)[1] == pytest.approx(enclosed(cup()), rel=0.02)
    # The case holds the points: it needs no file any more.
    path.unlink()
    assert merge_case(tomllib.loads(train.to_toml()), {}) == train
    with pytest.raises(CaseError, match="take a higher degree"):
        resting_shape(Cell(reference="profile", profile=spiky().tolist()), 6)


def mean_height(shape: np.ndarray) -> float:
    """By how much the file's shape was moved, from its upper pole."""
    return float(cup()[0, 1] - places(shape)[1][0])


def spiky() -> np.ndarray:
    points = cup()
    points[25:35, 1] += 0.1
    return points


def test_profile_of_a_sphere_is_the_sphere() -> None:
    theta = np.linspace(0, np.pi, 40)
    points = np.stack([np.sin(theta), np.cos(theta)], axis=1)
    points[[0, -1], 0] = 0.0
    shape = resting_shape(Cell(reference="profile", profile=points.tolist()), DEGREE)
    assert_allclose(shape, reference_coefficients(DEGREE, "sphere"), rtol=0, atol=1e-4)


def test_a_train_of_inflated_cells() -> None:
    train = Train(diameter=8, packing=0.2, cells=2, degree=6, tolerance=1e-4, reduced_volume=0.8)
    base = steady(train, estimate_error=False)
    held = meridian_membrane(train).volume(base.profile)
    area, _ = area_and_volume(reference_coefficients(6, "biconcave"))
    assert held == pytest.approx(0.8 * area**1.5 / (6 * np.sqrt(np.pi)), rel=1e-8)
    assert base.residual < 1e-9
    result = stability(base, azimuthal_numbers=(0, 1), estimate_error=False)
    assert np.isfinite(result.spectral_abscissa)
    # Volumes and turns about the axis are neutral as in any train.
    assert sum(mode.neutral for mode in result.modes) >= 2


def test_a_cell_that_has_no_room_at_rest_has_it_in_the_flow() -> None:
    narrow = Train(diameter=2.8, packing=0.2, degree=6, reduced_volume=0.45)
    assert size_at_rest(SteadyProblem(narrow).rest)[0] > 2.8
    base = steady(narrow, estimate_error=False)
    assert base.residual < 1e-9
    assert base.largest_radius < 1.4
    assert base.origin.startswith("march from the resting shape with diameter = ")


def test_cells_that_find_no_room_say_how_far_they_came() -> None:
    thick = Train(diameter=8, packing=0.7, degree=6, reduced_volume=0.95)
    with pytest.raises(NotConverged, match=r"up to packing = 0\.5"):
        steady(thick)
