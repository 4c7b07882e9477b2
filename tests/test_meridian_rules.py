"""The sizes of rules on a meridian: errors fall as they are chosen for."""

import math

import numpy as np
import pytest

from celltrain.harmonics import Profile
from celltrain.meridian.grids import HalfCircle, meridian_grid
from celltrain.meridian.images import force_image
from celltrain.meridian.moments import SINGLE, member_matrix
from celltrain.meridian.rules import MOST_SOURCES, Rules, choose_rules

DEGREE = 6


def sphere() -> Profile:
    profile = np.zeros((2, DEGREE))
    profile[:, 1] = np.sqrt(4 * np.pi / 3), np.sqrt(8 * np.pi / 3)
    return profile


def velocity(distance: float, order: int, longitudes: int) -> np.ndarray:
    """Beside the equator, above a pole, and between."""
    places = (1 + distance) * np.array([[0.0, 1.0, 0.8], [1.0, 1e-9, 0.6]])
    targets = places[0], places[1]
    grid, circle = meridian_grid(DEGREE, order), HalfCircle(longitudes)
    image = force_image(grid, circle, targets, sphere(), sphere(), 0.0, 4)
    return np.stack(
        [
            member_matrix(image.at, SINGLE, 0)[:, :, :DEGREE],
            *(member_matrix(image.at, SINGLE, m)[:, :, :DEGREE] for m in (1, 2)),
        ]
    )


@pytest.mark.parametrize("distance", [0.2, 0.5])
def test_error_of_smooth_sources(distance: float) -> None:
    exact = velocity(distance, 220, 200)
    for order in (16, 24, 32):
        found = velocity(distance, order, math.ceil(0.8 * order))
        error = np.abs(found - exact).max()
        # |dx/dtheta| is 1, and the radius too: the distance in the complex plane is log(1 + d).
        bound = 30 * math.exp(-2 * order * math.log1p(distance))
        assert error < max(bound, 1e-12)
        # Not by more than is needed: half as many would not do.
        half = velocity(distance, order // 2, math.ceil(0.4 * order))
        assert bound < 1e-9 or np.abs(half - exact).max() > 0.1 * bound


def test_rules_follow_the_room() -> None:
    def rules(period: float, radius: float, tolerance: float = 1e-8) -> Rules:
        return choose_rules(sphere(), period=period, radius=radius, targets=8, tolerance=tolerance)

    wide = rules(6.0, 3.0)
    assert wide.possible
    assert wide.nearest == 0
    assert rules(2.5, 3.0).nearest == 1
    digits = math.log(30 / 1e-8)
    near = rules(2.2, 3.0)
    assert 0.5 * digits / 0.2 <= near.image_sources <= 1.125 * 0.5 * digits / 0.2 + 1
    narrow = rules(6.0, 1.05)
    assert 0.5 * digits / 0.1 <= narrow.sources <= 1.125 * 0.5 * digits / 0.1 + 1
    assert narrow.image_sources == wide.image_sources
    for touching in (rules(2.0, 3.0), rules(6.0, 1.0), rules(6.0, 0.9)):
        assert max(touching.sources, touching.image_sources) == MOST_SOURCES + 1
        assert not touching.possible
    finer = wide.finer()
    assert finer.covers(wide.finer())
    assert not wide.covers(finer)
    assert finer.targets > wide.targets
    assert finer.tolerance < wide.tolerance
    assert rules(6.0, 3.0, 1e-12).radial > wide.radial


def test_each_place_asks_with_its_own_distance() -> None:
    """Poles that are near need few points around the axis, and few of a membrane that is short."""

    def rules(profile: Profile, period: float) -> Rules:
        return choose_rules(profile, period=period, radius=3.0, targets=8)

    flat = sphere() * np.array([[0.5], [1.0]])
    # The equator is nearest to no other cell, and the stretch at the pole is that of the sphere.
    gap = 0.1
    round_poles, near = rules(sphere(), 2.0 + gap), rules(flat, 1.0 + gap)
    digits = math.log(30 / 1e-8)
    assert round_poles.image_sources >= 0.5 * digits / gap
    # Spheres part as rho^2: the rings at the distance gap + rho^2 ask for rho/(gap + rho^2).
    around = 0.5 * digits * 0.5 / math.sqrt(gap)
    assert around <= round_poles.image_half_circle <= 1.3 * around + 12
    assert near.image_half_circle > round_poles.image_half_circle
