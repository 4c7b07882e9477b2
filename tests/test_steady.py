"""Steady trains: that they are steady, and that there are several ways to them."""

import sys
from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain import Base, NotConverged, Train, steady
from celltrain.harmonics import Profile
from celltrain.meridian.geometry import largest_radius, meridian_points
from celltrain.proximity.meridian import streamwise_gap
from celltrain.steady import Iteration, iterate, path, ways
from celltrain.steady.degree import DEGREES
from celltrain.steady.iterate import Iterated
from celltrain.steady.path import change_degree
from celltrain.steady.problem import SteadyProblem
from celltrain.steady.solve import at_degree


def test_steady_train_is_steady(coarse_base: Base) -> None:
    assert coarse_base.residual < 1e-9
    problem = SteadyProblem(coarse_base.train)
    held = problem.membrane.volume(coarse_base.profile)
    assert_allclose(held, problem.target_volume, rtol=0, atol=1e-9)
    # Its mean point is at the origin.
    assert_allclose(coarse_base.coefficients[:, 0], 0.0, atol=1e-12)


def test_what_is_told_of_it(coarse_base: Base) -> None:
    # Faster than the mean flow, slower than the flow on the axis.
    assert 1.0 < coarse_base.cell_velocity < 2.0
    assert 1.0 < coarse_base.effective_viscosity < 2.0
    assert coarse_base.largest_radius == pytest.approx(
        largest_radius(coarse_base.profile), rel=1e-14
    )
    assert coarse_base.gap == pytest.approx(streamwise_gap(coarse_base.profile, 1 / 0.3), rel=1e-13)
    assert coarse_base.origin == "march from the resting shape"
    assert set(coarse_base.seconds) == {"compile", "base"}
    methods = [step.method for step in coarse_base.history]
    assert methods[0] == "march"
    assert methods[-1] == "newton"
    # Newton's method squares the residual, until roundoff.
    residuals = [step.residual for step in coarse_base.history if step.method == "newton"]
    assert any(after < 20 * before**2 for before, after in pairwise(residuals))


def test_continuation_and_march_lead_to_the_same_train(coarse_base: Base) -> None:
    seen: list[Iteration] = []
    nearby = steady(coarse_base.train.changed(packing=0.29), progress=seen.append)
    assert tuple(seen) == nearby.history
    assert abs(nearby.cell_velocity - coarse_base.cell_velocity) > 1e-4
    # The number of cells does not matter.
    followed = steady(coarse_base.train.changed(cells=1), start=nearby)
    assert {step.method for step in followed.history} == {"newton"}
    assert_allclose(followed.coefficients, coarse_base.coefficients, rtol=0, atol=1e-8)
    assert_allclose(followed.cell_velocity, coarse_base.cell_velocity, rtol=0, atol=1e-9)
    assert "packing = 0.29" in followed.origin
    assert "cells = 3" in followed.origin


def test_start_from_the_solution_is_the_solution(coarse_base: Base) -> None:
    again = steady(coarse_base.train, start=coarse_base)
    assert again.history == ()
    assert_allclose(again.coefficients, coarse_base.coefficients, rtol=0, atol=1e-14)


def test_a_train_whose_membrane_crosses_itself_is_refused(
    coarse_base: Base, monkeypatch: pytest.MonkeyPatch
) -> None:
    solve = sys.modules["celltrain.steady.solve"]
    monkeypatch.setattr(solve, "crosses_itself", lambda profile: True)
    with pytest.raises(NotConverged, match="of the one that was found crosses itself") as failure:
        steady(coarse_base.train, start=coarse_base)
    assert failure.value.last.residual < 1e-9


def test_a_march_that_is_cut_short_says_so(coarse_base: Base) -> None:
    with pytest.raises(NotConverged, match="2 iterations") as failure:
        steady(coarse_base.train, max_iterations=2)
    last = failure.value.last
    assert len(last.history) == 2
    assert failure.value.history == last.history == coarse_base.history[:2]
    assert last.residual > 1e-3
    assert f"{last.residual:.2e}" in str(failure.value)
    # And it is a way to go on.
    followed = steady(coarse_base.train, start=last)
    assert_allclose(followed.coefficients, coarse_base.coefficients, rtol=0, atol=1e-8)


def test_a_march_after_newtons_method_begins_with_a_step_of_its_own(
    coarse_base: Base, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And leaves the cutting of Newton's steps to its own."""
    problem = SteadyProblem(coarse_base.train.changed(packing=0.29))
    halvings: list[object] = []

    def newton(*given: object, **how: object) -> Iterated:
        halvings.append(how["halvings"])
        return found(*given, **how)  # type: ignore[arg-type]

    found = iterate.newton
    monkeypatch.setattr(iterate, "newton", newton)
    for failed, first in ((False, "newton"), (True, "march")):
        reached = iterate.march(
            problem, coarse_base.profile, tolerance=1e-9, most=40, newton_failed=failed
        )
        assert reached.steady
        assert reached.history[0].method == first
    assert set(halvings) == {iterate.FEW_HALVINGS}
    assert iterate.FEW_HALVINGS < iterate.MOST_HALVINGS


def test_change_of_degree() -> None:
    profile = np.random.default_rng(0).normal(size=(2, 6))
    profile[1, 0] = 0.0
    finer = change_degree(profile, 8)
    for here, there in zip(meridian_points(profile), meridian_points(finer), strict=True):
        assert_allclose(there, here, rtol=0, atol=1e-14)
    assert_allclose(change_degree(finer, 6), profile, rtol=0, atol=0)


def test_a_train_without_a_degree_gets_one() -> None:
    base = steady(Train(diameter=6, packing=0.2))
    assert base.train.resolution.degree in DEGREES[2:-2]
    assert base.velocity_error < 1e-4
    finer = steady(base.train.changed(degree=DEGREES[-2]), start=base, estimate_error=False)
    assert_allclose(base.cell_velocity, finer.cell_velocity, rtol=0, atol=1e-4)


@pytest.mark.slow
def test_the_flow_leads_to_a_degree_where_newtons_method_does_not() -> None:
    # Soft cells, as in the paper's Fig. 15 (b).
    train = Train(diameter=8, packing=0.2, cells=1, degree=16)
    softer = 0.8 * train.cell.capillary_number / 20.5
    moduli = ("shear_modulus", "dilatation_modulus", "bending_modulus")
    train = train.changed(**{name: softer * getattr(train.cell, name) for name in moduli})
    coarse = steady(train, estimate_error=False)
    fine = steady(train.changed(degree=20), start=coarse, estimate_error=False)
    assert fine.residual < 1e-9
    assert "march" in {step.method for step in fine.history}
    assert fine.cell_velocity == pytest.approx(1.88355, abs=1e-5)


def test_a_cell_squeezes_through_a_capillary_of_five_micrometres() -> None:
    train = Train.from_si(
        diameter=5.6e-6, mean_velocity=1e-3, radius=2.8e-6, packing=0.2, cells=1, degree=20
    )
    base = steady(train, estimate_error=False)
    assert base.residual < 1e-9
    assert base.form == "bullet with a dimple"
    # What M = 32 has; M = 20 leaves 0.6 %.
    assert base.cell_velocity == pytest.approx(1.2462, rel=1e-2)
    assert base.effective_viscosity == pytest.approx(1.4012, rel=1e-2)


def test_what_was_tried_is_said() -> None:
    train = Train(diameter=1.5, packing=0.38, cells=1, degree=8)
    with pytest.raises(NotConverged, match=r"tried: march .*, up to ") as failure:
        steady(train, max_iterations=40)
    assert "wanted 1e-09 U" in str(failure.value)


def test_no_way_is_tried_twice(coarse_base: Base, monkeypatch: pytest.MonkeyPatch) -> None:
    """At another degree: Newton's method, and the march where it fails; then not from rest."""
    tried: list[str] = []

    def newton(problem: SteadyProblem, profile: Profile, **_: object) -> Iterated:
        tried.append(f"Newton at degree {problem.degree}")
        return Iterated(problem.state(profile), (), "step")

    def march(problem: SteadyProblem, profile: Profile, **how: object) -> Iterated:
        tried.append(f"march at degree {problem.degree}, after Newton: {how['newton_failed']}")
        return Iterated(problem.state(profile), (), "step")

    monkeypatch.setattr(ways, "newton", newton)
    monkeypatch.setattr(ways, "march", march)
    higher = coarse_base.train.degree + 1
    with pytest.raises(NotConverged):
        at_degree(coarse_base, higher)
    once = [f"Newton at degree {higher}", f"march at degree {higher}, after Newton: True"]
    assert tried == once
    # What users ask for is sought from rest after all, where that is another way.
    monkeypatch.setattr(path, "newton", newton)
    tried.clear()
    with pytest.raises(NotConverged):
        steady(coarse_base.train.changed(packing=0.25), start=coarse_base)
    assert any("after Newton: False" in each for each in tried)
