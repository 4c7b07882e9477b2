"""Periodic images of a cell: one by one on product grids, and in closed form."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain.harmonics import Profile
from celltrain.meridian.grids import HalfCircle, MeridianGrid, meridian_grid
from celltrain.meridian.images import ImageMoments, force_image, stress_image
from celltrain.meridian.moments import SINGLE, SLOPE, STRESS, member_matrix
from celltrain.meridian.tail import Tail

DEGREE, SIZE = 5, 36
PERIOD = 1.7
CIRCLE = HalfCircle(24)
NUMBERS = (0, 1, 2, 3)
#: Targets off the cell, within half a period.
TARGETS = (np.array([-0.4, 0.1, 0.5]), np.array([1.3, 1.6, 0.2]))


def cell() -> Profile:
    """Like a lens, hollow at the rear."""
    profile = np.zeros((2, DEGREE))
    profile[:, 1] = 0.3, 2.6
    profile[0, 2:] += [0.2, 0.05, -0.04]
    profile[1, 2:] += [-0.15, 0.1, 0.0]
    return profile


def forces() -> Profile:
    """Without a resultant."""
    random = np.random.default_rng(1).normal(size=(2, DEGREE))
    random[:, 0] = 0.0
    return random


def grid() -> MeridianGrid:
    return meridian_grid(DEGREE, SIZE)


def image(shift: float, orders: int = 6) -> ImageMoments:
    return force_image(grid(), CIRCLE, TARGETS, cell(), forces(), shift, orders)


def members_without_resultant(m: int) -> np.ndarray:
    """All members but those of degree 0."""
    count = grid().members(m).shape[1]
    kept = np.ones(count, dtype=bool)
    if m == 0:
        kept[0] = False
    if m == 1:
        kept[2 * DEGREE - 3] = False
    return np.eye(count)[:, kept]


def tail(nearest: int, smallest_phase: float = 0.5, tolerance: float = 1e-13) -> Tail:
    z, z_target = grid().places(cell())[0], TARGETS[0]
    both = np.concatenate([z, z_target])
    return Tail(
        period=PERIOD,
        nearest=nearest,
        distance=(nearest + 1) * PERIOD - float(both.max() - both.min()),
        smallest_phase=smallest_phase,
        tolerance=tolerance,
        sources=grid().places(cell()),
        targets=TARGETS,
        orders=max(NUMBERS) + 3,
    )


def on_the_circle(field: np.ndarray, m: int, phi: np.ndarray) -> np.ndarray:
    """Cartesian components [3, point, longitude] of u exp(i m phi), from R, Phi, Z [3, point]."""
    radial, around, axial = (each[:, None] * np.exp(1j * m * phi) for each in field)
    around = -1j * around
    cosine, sine = np.cos(phi), np.sin(phi)
    return np.stack([radial * cosine - around * sine, radial * sine + around * cosine, axial])


def dyad(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    return first[:, None] * second


@pytest.mark.parametrize("m", [0, 1, 2, 4])
def test_moments_of_an_image_by_plain_sums(m: int) -> None:
    shift = 2.1
    phi = 2 * np.pi * (np.arange(48) + 0.5) / 48
    (z, rho), members = grid().places(cell()), grid().members(m)
    area, force = (each[::-1] for each in (grid().area_vectors(cell()), grid().places(forces())))
    none = np.zeros_like(z)
    normal, force = (on_the_circle(np.stack([r, none, x]), 0, phi) for r, x in (area, force))
    y = on_the_circle(np.stack([rho, none, z + shift]), 0, phi).real
    weights = (grid().weights / (8 * np.pi))[:, None] * np.full(48, 2 * np.pi / 48)
    layers = image(shift)
    double = stress_image(grid(), CIRCLE, TARGETS, cell(), shift, 6)
    found = [
        member_matrix(layers.at, SINGLE, m),
        member_matrix(layers.at, SLOPE, m),
        member_matrix(double.at, STRESS, m),
    ]
    for t, (height, radius) in enumerate(zip(*TARGETS, strict=True)):
        d = np.array([radius, 0.0, height])[:, None, None] - y
        r = np.sqrt((d * d).sum(0))
        delta = np.eye(3)[..., None, None]
        stokeslet = delta / r + dyad(d, d) / r**3
        along = (d * force).sum(0)
        # [i, k]: the slope of component i in direction k.
        carried = delta * along - dyad(force, d) + dyad(d, force)
        slopes = carried / r**3 - 3 * dyad(d, d) * along / r**5
        stress = 6 * dyad(d, d) * (d * normal).sum(0) / r**5
        for member in range(members.shape[1]):
            content = on_the_circle(members[:, member], m, phi)
            for kernel, matrix in zip((stokeslet, slopes, stress), found, strict=True):
                x, around, axial = np.einsum("iktp,ktp,tp->i", kernel, content, weights)
                expected = np.array([x, 1j * around, axial])
                assert_allclose(matrix[t, :, member], expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize("phase", [0.0, 0.001, 1.0, np.pi, -2.0])
@pytest.mark.parametrize("m", NUMBERS)
def test_images_leave_the_tail_one_by_one(m: int, phase: float) -> None:
    displaced = grid().sources(m)
    # Members' forces: any matrix without resultants.
    kept = members_without_resultant(m)
    forced = kept @ np.random.default_rng(2).normal(size=kept.shape[::-1])
    smallest = abs(phase) or 0.5

    def total(nearest: int) -> np.ndarray:
        rest = tail(nearest, smallest)
        moments = rest.of_forces(m, grid().places(forces()), displaced, displaced @ forced)
        layers = rest.of_stresses(m, grid().area_vectors(cell()), displaced)
        velocity = rest.velocity(m, phase, moments), rest.velocity(m, phase, layers)
        found = np.stack(velocity)
        for p in [p for p in range(-nearest, nearest + 1) if p != 0]:
            one = image(p * PERIOD)
            double = stress_image(grid(), CIRCLE, TARGETS, cell(), p * PERIOD, 6)
            single = member_matrix(one.at, SINGLE, m) @ forced - member_matrix(one.at, SLOPE, m)
            each = np.stack([single, member_matrix(double.at, STRESS, m)])
            found = found + np.exp(1j * phase * p) * each
        return found

    closed = total(0)
    for nearest in (1, 2):
        assert_allclose(total(nearest), closed, rtol=0, atol=2e-11 * np.abs(closed).max())
    assert np.abs(closed).max() > 1e-3


@pytest.mark.parametrize("m", NUMBERS)
def test_far_tails_vanish(m: int) -> None:
    # With the test above: the tail is the sum of all images.
    forced = grid().sources(m) @ members_without_resultant(m)
    near, far, farther = (
        np.abs(rest.velocity(m, 0.0, rest.of_resting_forces(m, forced))).max()
        for rest in (tail(0), tail(100), tail(200))
    )
    assert far < 0.03 * near
    # Dipoles leave what falls as 1/P.
    assert farther < 0.52 * far


@pytest.mark.parametrize("phase", [0.0, 0.7])
@pytest.mark.parametrize("m", NUMBERS)
def test_gradient_of_the_tail(m: int, phase: float) -> None:
    forced = grid().sources(m) @ members_without_resultant(m)
    here = tail(1)
    moments = here.of_resting_forces(m, forced)
    h = 1e-4

    def moved(radial: float, axial: float) -> np.ndarray:
        z, rho = TARGETS
        moving = Tail(
            period=PERIOD,
            nearest=1,
            distance=2 * PERIOD - 2.0,
            smallest_phase=0.5,
            tolerance=1e-13,
            sources=grid().places(cell()),
            targets=(z + axial, rho + radial),
            orders=max(NUMBERS) + 3,
        )
        return moving.velocity(m, phase, moving.of_resting_forces(m, forced))

    by_radius, by_height = here.gradient(m, phase, moments)
    differences = (moved(h, 0) - moved(-h, 0)) / (2 * h), (moved(0, h) - moved(0, -h)) / (2 * h)
    assert_allclose(by_radius, differences[0], rtol=0, atol=1e-7)
    assert_allclose(by_height, differences[1], rtol=0, atol=1e-7)
