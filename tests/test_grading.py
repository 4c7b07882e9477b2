"""Graded meridians: the same cell in other coordinates, which a degree follows further."""

import numpy as np
import pytest

from celltrain import Train, steady
from celltrain.harmonics import profile_of
from celltrain.harmonics.grading import graded, regraded, usual
from celltrain.membrane import meridian_membrane, resting_shape
from celltrain.meridian.geometry import meridian_points
from celltrain.parameters import CaseError, Cell
from celltrain.stability.linearise import linear_blocks
from celltrain.steady.solve import KNOWN_VELOCITY

GRADINGS = (0.3, 1.0)


@pytest.mark.parametrize("grading", GRADINGS)
def test_colatitudes_rise_from_pole_to_pole_and_have_an_inverse(grading: float) -> None:
    # Not the points from which the inverse is sought.
    theta = np.linspace(0.0, np.pi, 998)
    psi = graded(theta, grading)
    assert psi[0] == 0.0
    assert psi[-1] == pytest.approx(np.pi, abs=1e-15)
    assert (np.diff(psi) > 0.0).all()
    assert np.abs(usual(psi, grading) - theta).max() < 1e-14
    # Drawn together where cells are sharp: more of psi for the same theta.
    rise = np.gradient(psi, theta)
    assert rise[np.abs(theta - 2.3).argmin()] > 1.0 + 0.2 * grading
    assert rise[np.abs(theta - 1.3).argmin()] < 1.0 - 0.2 * grading


def test_a_graded_resting_cell_is_the_same_cell() -> None:
    usual_cell, graded_cell = (
        meridian_membrane(Train(diameter=4, packing=0.1, cells=1, degree=32, grading=grading))
        for grading in (0.0, 1.0)
    )
    for measure in ("area", "volume"):
        values = [getattr(each, measure)(each.rest_profile) for each in (usual_cell, graded_cell)]
        assert values[1] == pytest.approx(values[0], rel=1e-9)
    assert not np.allclose(usual_cell.rest_profile, graded_cell.rest_profile, atol=1e-2)


def test_regrading_there_and_back_and_points_of_the_same_meridian() -> None:
    profile = profile_of(resting_shape(Cell(reduced_volume=0.7), 40))
    other = regraded(profile, 0.0, 1.0)
    assert np.abs(regraded(other, 1.0, 0.0) - profile).max() < 1e-7
    # Every point of the graded meridian is the usual one of its own theta.
    rho, z = meridian_points(other, 2001)
    psi = np.linspace(0.0, np.pi, 2001)
    theta = usual(psi, 1.0)
    known_rho, known_z = meridian_points(profile, 2001)
    assert np.abs(np.interp(theta, psi, known_rho) - rho).max() < 1e-6
    assert np.abs(np.interp(theta, psi, known_z) - z).max() < 1e-6


def test_trains_and_their_dynamics_do_not_depend_on_the_grading() -> None:
    train = Train(diameter=4, packing=0.2, cells=4, degree=24)
    base = steady(train, estimate_error=False)
    other = steady(train.changed(grading=0.5), start=base, estimate_error=False)
    assert other.residual < 1e-9
    # It begins at the same meridian, which the other grading has left at 0.9 U as it stood.
    assert other.history[0].residual < 0.1
    # Up to what the degree leaves of either.
    assert other.cell_velocity == pytest.approx(base.cell_velocity, abs=KNOWN_VELOCITY)
    assert other.effective_viscosity == pytest.approx(base.effective_viscosity, abs=KNOWN_VELOCITY)
    tilts = [
        np.linalg.eigvals(linear_blocks(each, [0.5 * np.pi], [1])[1][0]).real.max()
        for each in (base, other)
    ]
    assert tilts[1] == pytest.approx(tilts[0], abs=1e-3)


@pytest.mark.slow
def test_narrow_tubes_leave_less_out_with_grading() -> None:
    train = Train(diameter=2.2, packing=0.1, cells=1, degree=24)
    base = steady(train, estimate_error=False)
    other = steady(train.changed(grading=1.0), start=base, estimate_error=False)
    # Measured: 3.5e-3 U with, 4.9e-3 without.
    assert other.truncation_error < 0.8 * base.truncation_error


def test_gradings_beyond_one_are_refused() -> None:
    with pytest.raises(CaseError, match=r"grading = 1\.5 is not allowed; allowed: a number 0 to 1"):
        Train(diameter=4, packing=0.1, grading=1.5)
