"""Which tubes a cell passes, and how many cells there is room for."""

import math

import pytest

from celltrain import CaseError, Train, steady
from celltrain.steady.room import check_room, least_diameter

DEGREE = 8


def test_a_sphere_passes_no_tube_that_is_narrower_than_itself() -> None:
    for radius in (0.3, 1.0, 2.0):
        area, volume = 4.0 * math.pi * radius**2, 4.0 / 3.0 * math.pi * radius**3
        assert least_diameter(area, volume) == pytest.approx(2.0 * radius, rel=1e-7)


def test_a_cylinder_with_two_half_spheres_fills_its_tube() -> None:
    radius, length = 0.4, 3.0
    area = 4.0 * math.pi * radius**2 + 2.0 * math.pi * radius * length
    volume = 4.0 / 3.0 * math.pi * radius**3 + math.pi * radius**2 * length
    assert least_diameter(area, volume) == pytest.approx(2.0 * radius, rel=1e-12)


def test_a_tube_that_no_cell_passes_is_refused() -> None:
    case = {"packing": 0.2, "degree": DEGREE}
    check_room(Train(diameter=1.08, **case))
    for compute in (check_room, steady):
        with pytest.raises(CaseError, match=r"diameter = 1 .* allowed: > 1\.07"):
            compute(Train(diameter=1.0, **case))
    # A sphere has nothing to spare.
    with pytest.raises(CaseError, match=r"allowed: > 2\.0000"):
        check_room(Train(diameter=1.99, reference="sphere", **case))


def test_cells_that_are_more_than_the_tube_holds_are_refused() -> None:
    # A volume of 4 pi/3 in pi (D/2)^2 for each cell.
    most = 0.75 * 1.2**2
    case = {"diameter": 2.4, "degree": DEGREE, "reference": "sphere"}
    check_room(Train(packing=0.999 * most, **case))
    with pytest.raises(CaseError, match=r"fill more than the tube; allowed: > 0 and < 1\.0800"):
        steady(Train(packing=1.1, **case))


def test_cells_that_would_overlap_in_a_wide_tube_are_refused() -> None:
    # A closed surface has at least twice the area of its shadow: for a sphere half of 4 pi.
    case = {"diameter": 6, "degree": DEGREE, "reference": "sphere"}
    check_room(Train(packing=1.499, **case))
    with pytest.raises(CaseError, match=r"would overlap; allowed: > 0 and < 1\.5000"):
        steady(Train(packing=1.51, **case))
    with pytest.raises(CaseError, match=r"packing = 3 .* allowed: > 0 and < 2\.\d+"):
        check_room(Train(diameter=6, packing=3, degree=DEGREE))


def test_the_cases_degree_need_not_be_known() -> None:
    with pytest.raises(CaseError, match=r"allowed: > 1\.07"):
        steady(Train(diameter=1.0, packing=0.2))


def test_a_sparse_train_takes_a_few_iterations() -> None:
    base = steady(Train(diameter=6, packing=0.05, degree=DEGREE), estimate_error=False)
    assert base.residual < 1e-9
    assert len(base.history) <= 12


def test_a_tube_as_narrow_as_the_cell_at_rest() -> None:
    base = steady(Train(diameter=2.8, packing=0.2, degree=DEGREE), estimate_error=False)
    assert base.residual < 1e-9
    # It has become slimmer and longer.
    assert base.largest_radius < 1.1
    assert 1.0 < base.cell_velocity < 2.0


def test_a_packing_at_which_cells_at_rest_touch() -> None:
    base = steady(Train(diameter=6, packing=0.9, degree=DEGREE), estimate_error=False)
    assert base.residual < 1e-9
    assert 0.05 < base.gap < 0.15


def test_shapes_that_touch_are_left_without_ado() -> None:
    # A sphere in a tube of its own size has no rules; the way to it begins elsewhere.
    base = steady(
        Train(diameter=2.0005, packing=0.2, degree=DEGREE, reference="sphere"),
        estimate_error=False,
    )
    assert base.residual < 1e-9
    assert "diameter = 3" in base.origin
