"""The narrowest tube that a cell passes, and how many cells fit."""

import math

import pytest
from numpy.testing import assert_allclose

from celltrain import CaseError, Train
from celltrain.membrane import meridian_membrane
from celltrain.steady.room import check_room, least_diameter


def test_sphere_passes_tubes_of_its_diameter() -> None:
    area, volume = 4 * math.pi, 4 * math.pi / 3
    assert_allclose(least_diameter(area, volume), 2.0, rtol=1e-6)


@pytest.mark.parametrize(("radius", "length"), [(0.7, 1.5), (0.9, 0.1), (0.3, 12.0)])
def test_cylinders_with_half_spheres(radius: float, length: float) -> None:
    area = 4 * math.pi * radius**2 + 2 * math.pi * radius * length
    volume = 4 * math.pi / 3 * radius**3 + math.pi * radius**2 * length
    assert_allclose(least_diameter(area, volume), 2 * radius, rtol=1e-10)


def test_healthy_cell_passes_a_narrow_tube() -> None:
    train = Train(diameter=6, packing=0.2, cells=1, degree=12)
    membrane = meridian_membrane(train)
    least = least_diameter(membrane.area(membrane.rest_profile), membrane.volume(membrane.rest_profile))
    assert 1.0 < least < 1.2
    check_room(train.changed(diameter=1.01 * least))
    with pytest.raises(CaseError, match=rf"diameter = 1 is not allowed: .*allowed: > {least:.4f}"):
        check_room(train.changed(diameter=1.0))


def test_cells_that_would_fill_more_than_the_tube() -> None:
    train = Train(diameter=2.5, packing=0.2, cells=1, degree=8)
    membrane = meridian_membrane(train)
    most = math.pi * 1.25**2 / membrane.volume(membrane.rest_profile)
    with pytest.raises(CaseError, match=rf"fill more than the tube; allowed: > 0 and < {most:.4f}"):
        check_room(train.changed(packing=1.01 * most))
    check_room(train.changed(packing=0.99 * most))
