"""A cell's own surface in free space: spheres, whose layers are known, and identities."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain.harmonics import Profile
from celltrain.meridian.geometry import volume_gradient
from celltrain.meridian.grids import MeridianGrid
from celltrain.meridian.moments import SINGLE, SLOPE, STRESS, member_matrix
from celltrain.meridian.own_surface import OwnMoments, force_moments, own_rule, stress_moments

DEGREE = 8
TARGETS = DEGREE + 2


def sphere(degree: int = DEGREE) -> Profile:
    profile = np.zeros((2, degree))
    profile[:, 1] = np.sqrt(4 * np.pi / 3), np.sqrt(8 * np.pi / 3)
    return profile


def bell(degree: int = DEGREE) -> Profile:
    """Hollow at the rear, of few harmonics."""
    profile = sphere(degree)
    profile[0, :4] += [0.3, -0.9, 0.5, 0.1]
    profile[1, 1:4] += [0.6, -0.2, 0.1]
    return profile


def layer(
    profile: Profile, radial: float, around: float, force: Profile | None = None
) -> OwnMoments:
    rule = own_rule(DEGREE, TARGETS, round(radial * DEGREE), round(0.5 * around * DEGREE))
    return stress_moments(rule, profile) if force is None else force_moments(rule, profile, force)


def vector_harmonics(grid: MeridianGrid, n: int, m: int) -> dict[str, np.ndarray]:
    """Vector harmonics V, W, X of the sphere as amplitudes [point, 3]."""
    tables, theta = grid.tables(m + 1), grid.theta
    value, slope = tables.value[m, n], tables.slope[m, n]
    cosine, sine = np.cos(theta), np.sin(theta)

    def lengthwise(normal: float) -> np.ndarray:
        radial = slope * cosine + normal * value * sine
        axial = -slope * sine + normal * value * cosine
        return np.stack([radial, -m * value / sine, axial], axis=1)

    swirl = np.stack([-m * value * cosine / sine, slope, m * value], axis=1)
    return {"V": lengthwise(-(n + 1)), "W": lengthwise(n), "X": swirl}


@pytest.mark.parametrize("m", [0, 1, 2, 5])
@pytest.mark.parametrize("kind", ["single", "double"])
def test_layers_of_a_sphere(kind: str, m: int) -> None:
    force = sphere()
    moments = layer(sphere(), 5, 6, force if kind == "single" else None)
    assert isinstance(moments, OwnMoments)
    grid = moments.rule.targets
    matrix = member_matrix(moments.at, SINGLE if kind == "single" else STRESS, m)
    if kind == "double":
        xx, xz, zz, yy = moments.integrals
        radial, around, axial = grid.members(m).transpose(0, 2, 1)
        constants = np.stack(
            [
                xx[:, None] * radial + xz[:, None] * axial,
                yy[:, None] * around,
                xz[:, None] * radial + zz[:, None] * axial,
            ],
            axis=1,
        )
        matrix = matrix - constants - 0.5 * grid.members(m).transpose(2, 0, 1)
    for n in range(max(m, 1), DEGREE - 1):
        known = {
            "single": {
                "V": n / ((2 * n + 1) * (2 * n + 3)),
                "W": (n + 1) / ((2 * n + 1) * (2 * n - 1)),
                "X": 1 / (2 * n + 1),
            },
            "double": {
                "V": 1.5 / ((2 * n + 1) * (2 * n + 3)),
                "W": -1.5 / ((2 * n + 1) * (2 * n - 1)),
                "X": -1.5 / (2 * n + 1),
            },
        }[kind]
        for name, field in vector_harmonics(grid, n, m).items():
            velocity = matrix @ (grid.projection(m) @ field.ravel())
            assert_allclose(velocity, known[name] * field, rtol=0, atol=1e-12)


def test_constants_give_minus_a_half() -> None:
    errors = []
    for radial, around in ((3, 4), (6, 8), (9, 12)):
        xx, xz, zz, yy = layer(bell(), radial, around).integrals
        errors.append(max(np.abs(each + 0.5).max() for each in (xx, zz, yy)))
        errors[-1] = max(errors[-1], np.abs(xz).max())
    # The rule converges geometrically.
    assert errors[1] < 0.02 * errors[0]
    assert errors[2] < 0.02 * errors[1]


def test_normal_forces_do_nothing() -> None:
    # int G n dS = 0, and its derivative by the place of the target.
    profile = bell()
    n = volume_gradient(profile)
    force = np.stack([n[:DEGREE], np.append(0.0, n[DEGREE : 2 * DEGREE - 1])])
    errors = []
    for radial, around in ((4, 5), (8, 12)):
        moments = layer(profile, radial, around, force)
        errors.append(np.abs(member_matrix(moments.at, SINGLE, 0) @ n).max())
    assert errors[1] < 1e-9
    assert errors[1] < 1e-2 * errors[0]


@pytest.mark.parametrize("m", [0, 1, 2])
def test_targets_and_sources_that_move_together(m: int) -> None:
    # Either part alone is strongly singular; translations of both do nothing.
    profile, force = bell(), bell()
    force[0, 0] = 0.0

    def bracket(radial: float, around: float) -> np.ndarray:
        moments = layer(profile, radial, around, force)
        radially, sideways, axially = moments.rule.targets.members(m).transpose(0, 2, 1)
        xx, xz, zx, zz, yy = (each[:, None] for each in moments.integrals[4:9])
        rows = (xx * radially + xz * axially, yy * sideways, zx * radially + zz * axially)
        return np.stack(rows, axis=1) - member_matrix(moments.at, SLOPE, m)

    coarse, fine, finest = (bracket(*rule) for rule in ((4, 5), (6, 8), (9, 12)))
    for translation in {0: [0], 1: [2 * DEGREE - 3]}.get(m, []):
        assert_allclose(coarse[:, :, translation], 0.0, atol=1e-11)
    low = slice(0, 4)
    error, left = (np.abs(each - finest)[..., low].max() for each in (coarse, fine))
    assert left < 0.05 * error
