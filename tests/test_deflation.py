"""Newton's method with known roots taken out finds the others; a search says what it tried."""

import itertools
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain import Base, CaseError, load
from celltrain.analyses import search as command
from celltrain.cli import main
from celltrain.continuation import (
    BranchSearch,
    Evaluation,
    FoundTrain,
    NoSolution,
    SearchTry,
    Tries,
    deflated_newton,
    search_trains,
)
from celltrain.continuation.deflation import deflated_step, deflation
from celltrain.continuation.equations import evaluate_steady, known_point, to_unknowns
from celltrain.continuation.guesses import FITTING, first_guesses, reversed_profile, squeezed
from celltrain.continuation.tries import SAME, by_deflation, by_flow
from celltrain.harmonics import UNIT_DISPLACEMENT, coefficients_of
from celltrain.meridian.geometry import largest_radius, meridian_points
from celltrain.proximity.meridian import crosses_itself
from celltrain.steady.form import form_of
from celltrain.steady.iterate import Iterated
from celltrain.steady.path import change_degree
from celltrain.steady.problem import SteadyProblem
from celltrain.steady.solve import at_degree

# x^3 = x and y^2 = 4: six roots.
ROOTS = {(x, y) for x in (-1.0, 0.0, 1.0) for y in (-2.0, 2.0)}
START = np.array([0.7, 1.3])


def problem(point: np.ndarray, _: None) -> Evaluation[None]:
    if np.abs(point).max() > 10.0:
        raise NoSolution("far away")
    residual = np.array([point[0] ** 3 - point[0], point[1] ** 2 - 4.0])
    jacobian = np.diag([3 * point[0] ** 2 - 1.0, 2 * point[1]])
    return Evaluation(residual, jacobian, float(np.abs(residual).max()), None)


def test_step_is_newtons_of_the_deflated_equations() -> None:
    known = [np.array([1.0, 2.0]), np.array([-1.0, 2.0])]
    point = np.array([0.4, 1.1])

    def deflated(at: np.ndarray) -> np.ndarray:
        return deflation(at, known)[0] * problem(at, None).residual

    factors = [1.0 / np.sum((point - root) ** 2) + 1.0 for root in known]
    assert_allclose(deflation(point, known)[0], np.prod(factors), rtol=1e-14)
    step = 1e-6
    columns = [
        (deflated(point + step * unit) - deflated(point - step * unit)) / (2 * step)
        for unit in np.eye(2)
    ]
    expected = -np.linalg.solve(np.stack(columns, axis=1), deflated(point))
    here = problem(point, None)
    found = deflated_step(here.residual, here.jacobian, deflation(point, known)[1])
    assert_allclose(found, expected, rtol=1e-7)


def test_further_roots_from_few_starts() -> None:
    found: list[np.ndarray] = []
    for start in (START, -START, START * [1, -1], START * [-1, 1], np.array([0.1, 0.4])):
        for _ in range(len(ROOTS)):
            attempt = deflated_newton(problem, start, None, found, Tries(tolerance=1e-12))
            if not attempt.converged:
                break
            # Never the same one again, though Newton's method from here would find it for ever.
            assert all(np.linalg.norm(attempt.unknowns - root) > 0.5 for root in found)
            found.append(attempt.unknowns)
    assert {tuple(np.round(point, 9) + 0.0) for point in found} == ROOTS


def test_endings() -> None:
    attempt = deflated_newton(problem, START, None, [], Tries(most_steps=1))
    assert not attempt.converged
    assert attempt.reason == "1 steps were not enough"
    few = deflated_newton(problem, START, None, [], Tries(most_evaluations=3))
    assert not few.converged
    assert few.reason == "3 evaluations were not enough"
    # A first evaluation, and at least one for each step.
    assert 1 + few.steps <= few.evaluations
    with pytest.raises(NoSolution):
        deflated_newton(problem, 20.0 * START, None, [], Tries())


def test_a_try_that_comes_no_nearer_to_a_root_is_given_up() -> None:
    def falling(point: np.ndarray, _: None) -> Evaluation[None]:
        """1 + exp(-x) has no root, and falls for ever."""
        fall = np.exp(-point)
        return Evaluation(1.0 + fall, -np.diag(fall), float(1.0 + fall[0]), None)

    attempt = deflated_newton(falling, np.zeros(1), None, [], Tries(patience=7))
    assert not attempt.converged
    assert attempt.steps == 7
    assert attempt.reason == "given up: no nearer to a root within 7 steps"


def test_shapes_that_take_too_much_are_passed_by(
    coarse_base: Base, monkeypatch: pytest.MonkeyPatch
) -> None:
    known = known_point(coarse_base)
    wide = 0.98 * coarse_base.train.radius / largest_radius(coarse_base.profile)
    profile = coarse_base.profile * np.array([[1.0], [wide]])
    unknowns, work = to_unknowns(profile), known.problem.rules(profile).work
    assert evaluate_steady(known.problem, unknowns, known, most_work=work).error > 0.0
    with pytest.raises(NoSolution, match="all but touch"):
        evaluate_steady(known.problem, unknowns, known, most_work=work - 1)
    part = 0.9 * work / known.state.flow.rules.work
    monkeypatch.setattr("celltrain.continuation.tries.MOST_WORK", part)
    monkeypatch.setattr("celltrain.continuation.search._with_volume", lambda _, profile: profile)
    search = search_trains(coarse_base, guesses=[("a wide one", profile)])
    assert [each.way for each in search.tries] == ["flow", "deflation"]
    assert all("all but touch" in each.outcome for each in search.tries)


def test_meridians_of_cells(coarse_base: Base) -> None:
    profile = coarse_base.profile
    turned = reversed_profile(profile)
    assert not crosses_itself(profile)
    assert not crosses_itself(turned)
    assert_allclose(reversed_profile(turned), profile)
    (rho, z), (back_rho, back_z) = meridian_points(profile), meridian_points(turned)
    assert_allclose(back_rho, rho[::-1], atol=1e-13)
    assert_allclose(back_z, -z[::-1], atol=1e-13)
    # z = cos(3 theta) over rho = sin(theta) meets itself; cos(3 theta) = (8 P_3 - 3 P_1)/5.
    crossed = np.zeros_like(profile)
    crossed[1, 1] = np.sqrt(8 * np.pi / 3)
    crossed[0, 1], crossed[0, 3] = -0.6 * np.sqrt(4 * np.pi / 3), 1.6 * np.sqrt(4 * np.pi / 7)
    assert crosses_itself(crossed)
    crossed[0, 1] *= -1.0
    crossed[0, 3] = 0.0
    assert not crosses_itself(crossed)


def test_guesses_have_the_sizes_they_name(coarse_base: Base) -> None:
    guesses = dict(first_guesses(coarse_base))
    rest = guesses["the resting shape"]
    z = meridian_points(guesses["the resting shape, bent by +0.6 r0"] - rest, 201)[1]
    assert_allclose(z[0] - z[100], 0.6, rtol=1e-12)
    disturbed = guesses["the known one disturbed by 0.5 r0 (draw 3)"] - coarse_base.profile
    assert_allclose(np.linalg.norm(disturbed), 0.5 * UNIT_DISPLACEMENT, rtol=1e-12)
    assert len(guesses) == 19
    for name in ("a bullet", "a bullet with a dimple", "a parachute"):
        assert f"a {form_of(guesses[name])}" == name
    problem = SteadyProblem(coarse_base.train)
    for name in ("a parachute", "the resting shape, bent by -1.2 r0"):
        volume = problem.membrane.volume(guesses[name])
        assert_allclose(volume, problem.target_volume, rtol=1e-12)


def test_guesses_fit_into_the_tube(coarse_base: Base) -> None:
    problem = SteadyProblem(coarse_base.train)
    narrow = replace(coarse_base, train=coarse_base.train.changed(diameter=2.5))
    for name, profile in itertools.islice(first_guesses(narrow), 8):
        assert largest_radius(profile) <= FITTING * 1.25 * (1.0 + 1e-12), name
        assert_allclose(problem.membrane.volume(profile), problem.target_volume, rtol=1e-12)
    assert squeezed(problem.rest, 2.0) is problem.rest


def test_search_for_other_trains(coarse_base: Base) -> None:
    profile = coarse_base.profile
    moved = profile.copy()
    moved[0, 3] += 0.3
    guesses = [("the known one", profile), ("a moved one", moved)]
    search = search_trains(coarse_base, guesses=guesses, most_tries=5, tries=Tries(most_steps=8))
    outcomes = [each.outcome for each in search.tries]
    assert outcomes[:2] == ["came back to a known one", "the guess is a known train"]
    assert 4 <= len(search.tries) <= 5
    assert all(each.steps <= 8 for each in search.tries if each.way == "deflation")
    assert len(search.found) == sum(each.base is not None for each in search.tries)
    for each in search.found:
        assert each.base.residual < 1e-9
        assert each.distance > SAME


@pytest.mark.parametrize("way", ["flow", "deflation"])
def test_a_train_is_found_that_is_not_known(
    way: str, coarse_base: Base, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The one that the flow reaches, if its mirror image is pretended to be all that is known."""
    if way == "deflation":
        monkeypatch.setattr("celltrain.continuation.search.by_flow", by_deflation)
    turned = coefficients_of(reversed_profile(coarse_base.profile))
    pretended = replace(coarse_base, coefficients=turned)
    moved = coarse_base.profile.copy()
    moved[0, 3] += 0.05
    search = search_trains(pretended, guesses=[("a moved one", moved)], most_tries=1)
    assert (search.tries[0].way, search.tries[0].outcome) == (way, "found another train")
    found = search.found[0]
    assert found.axisymmetric_rate < 0.0
    # Followed to a degree half as high again, where it is the train that is found from rest.
    assert (search.degree, search.higher_degree) == (6, 12)
    finer = at_degree(coarse_base, 12)
    assert_allclose(found.base.coefficients, finer.coefficients, rtol=0, atol=1e-8)
    change = abs(finer.cell_velocity - coarse_base.cell_velocity)
    assert_allclose(found.velocity_change, change, rtol=1e-5)


def test_marches_that_lead_to_no_train_say_so(coarse_base: Base) -> None:
    known, profile = known_point(coarse_base), coarse_base.profile
    moved = profile.copy()
    moved[0, 3] += 0.3
    few = Tries(most_flow_steps=1)
    each, root = by_flow("a moved one", moved, known, [to_unknowns(profile)], few)
    assert (each.steps, each.outcome) == (1, "the flow became steady nowhere")
    assert (root, each.base) == (None, None)
    wide = profile * np.array([[1.0], [1.01 * coarse_base.train.radius]])
    each, root = by_flow("one beyond the wall", wide, known, [to_unknowns(profile)], few)
    assert (each.steps, each.outcome, root) == (0, "the guess has no room", None)


def test_what_is_a_train_at_a_low_degree_alone_is_counted_apart(
    coarse_base: Base, monkeypatch: pytest.MonkeyPatch
) -> None:
    turned = coefficients_of(reversed_profile(coarse_base.profile))
    pretended = replace(coarse_base, coefficients=turned)
    moved = coarse_base.profile.copy()
    moved[0, 3] += 0.05

    def nowhere(problem: SteadyProblem, profile: np.ndarray, **_: object) -> Iterated:
        return Iterated(problem.state(profile), (), "step")

    monkeypatch.setattr("celltrain.continuation.search.newton", nowhere)
    search = search_trains(pretended, guesses=[("a moved one", moved)], most_tries=1)
    assert search.found == ()
    assert search.tries[0].outcome == "found a train of degree 6 alone"
    assert search.alone == 1
    assert search.statement.endswith("at degree 6; 1 more is of this degree alone")

    def astray(problem: SteadyProblem, profile: np.ndarray, **_: object) -> Iterated:
        """To the known train instead."""
        rest = SteadyProblem(coarse_base.train).rest
        known = change_degree(pretended.profile - rest, problem.degree) + problem.rest
        return Iterated(problem.state(known), (), "steady")

    monkeypatch.setattr("celltrain.continuation.search.newton", astray)
    search = search_trains(pretended, guesses=[("a moved one", moved)], most_tries=1)
    assert (search.found, search.alone) == ((), 1)


def test_a_search_at_a_lower_degree(coarse_base: Base) -> None:
    finer = at_degree(coarse_base, 8)
    search = search_trains(finer, guesses=[("the known one", coarse_base.profile)], degree=6)
    assert (search.degree, search.higher_degree) == (6, 8)
    assert search.tries[1].outcome == "the guess is a known train"
    with pytest.raises(CaseError, match="degree = 64 is not allowed"):
        search_trains(finer, degree=64)


def test_what_is_refused(coarse_base: Base) -> None:
    with pytest.raises(CaseError, match="most_tries = 0"):
        search_trains(coarse_base, most_tries=0)


@pytest.fixture(scope="module")
def searched(coarse_base: Base) -> BranchSearch:
    """A search that nobody made: two tries from one guess, a further train, and no more."""
    other = replace(coarse_base, cell_velocity=1.5, origin="made up")
    tries = (
        SearchTry("the resting shape", "flow", 5, 0.2, "found another train", 1e-10, other),
        SearchTry("the resting shape", "deflation", 0, 0.1, "cells overlap", float("nan"), None),
    )
    found = (FoundTrain(other, "the resting shape", 0.7, 1e-3, -0.01),)
    return BranchSearch(coarse_base, 6, 12, tries, found)


def test_statements(searched: BranchSearch) -> None:
    assert searched.statement == (
        "1 further steady train was found in 2 tries from 1 guess at degree 6"
    )
    none = replace(searched, found=(), tries=searched.tries[1:])
    assert none.statement == ("no further steady train was found in 1 try from 1 guess at degree 6")


def test_command(
    searched: BranchSearch,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    asked = []

    def compute(
        base: Base, *, most_tries: int, progress: Callable[[SearchTry], None]
    ) -> BranchSearch:
        asked.append(most_tries)
        for each in searched.tries:
            progress(each)
        return searched

    monkeypatch.setattr(command, "steady", lambda train, **_: searched.known)
    monkeypatch.setattr(command, "search_trains", compute)
    case = ["search", "--diameter", "6", "--packing", "0.3", "--degree", "6"]
    files = ["-o", str(tmp_path / "trains.nc"), "--plot", str(tmp_path)]
    assert main([*case, "--most-tries", "2", "--json", *files]) == 0
    printed = capsys.readouterr()
    content = json.loads(printed.out)
    assert asked == [2]
    assert content["statement"] == searched.statement
    assert content["known"]["cell_velocity"] == searched.known.cell_velocity
    assert [each["residual"] for each in content["tries"]] == [1e-10, None]
    assert content["found"][0]["base"]["cell_velocity"] == 1.5
    assert "try 2: from the resting shape: cells overlap (deflation, 0 steps, 0.1 s)" in printed.err
    names = sorted(each.name for each in tmp_path.iterdir())
    assert names == ["search.png", "trains-1.nc", "trains.nc"]
    again = load(tmp_path / "trains-1.nc")
    assert isinstance(again, Base)
    assert again.cell_velocity == 1.5
    assert load(tmp_path / "trains.nc") == searched
    assert main([*case, "--quiet"]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    assert searched.statement in printed.out
    assert "0.700" in printed.out


def test_command_refuses(capsys: pytest.CaptureFixture[str]) -> None:
    case = ["search", "--diameter", "6", "--packing", "0.3"]
    assert main([*case, "--most-tries", "0"]) == 2
    assert "most_tries = 0 is not allowed" in capsys.readouterr().err
    assert main([*case, "--most-tries", "1.5"]) == 2
    assert "1.5" in capsys.readouterr().err
