"""Newton's method with known roots taken out finds the others; a search says what it tried."""

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
from celltrain.continuation.search import SAME, first_guesses, reversed_profile
from celltrain.harmonics import UNIT_DISPLACEMENT, coefficients_of
from celltrain.meridian.geometry import meridian_points
from celltrain.proximity.meridian import crosses_itself

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
    with pytest.raises(NoSolution):
        deflated_newton(problem, 20.0 * START, None, [], Tries())


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
    z = meridian_points(guesses["the resting shape bent by +0.6 r0"] - rest, 201)[1]
    assert_allclose(z[0] - z[100], 0.6, rtol=1e-12)
    disturbed = guesses["the known one disturbed by 0.5 r0 (draw 3)"] - coarse_base.profile
    assert_allclose(np.linalg.norm(disturbed), 0.5 * UNIT_DISPLACEMENT, rtol=1e-12)
    assert len(guesses) == 12


def test_search_for_other_trains(coarse_base: Base) -> None:
    profile = coarse_base.profile
    moved = profile.copy()
    moved[0, 3] += 0.3
    guesses = [("the known one", profile), ("a moved one", moved)]
    search = search_trains(coarse_base, guesses=guesses, most_tries=3, tries=Tries(most_steps=8))
    assert search.tries[0].outcome == "the guess is a known train"
    assert 2 <= len(search.tries) <= 3
    assert all(each.steps <= 8 for each in search.tries)
    assert len(search.found) == sum(each.base is not None for each in search.tries)
    for each in search.found:
        assert each.base.residual < 1e-9
        assert each.distance > SAME


def test_a_train_is_found_that_is_not_known(coarse_base: Base) -> None:
    """The one that the flow reaches, if its mirror image is pretended to be all that is known."""
    turned = coefficients_of(reversed_profile(coarse_base.profile))
    pretended = replace(coarse_base, coefficients=turned)
    moved = coarse_base.profile.copy()
    moved[0, 3] += 0.05
    search = search_trains(pretended, guesses=[("a moved one", moved)], most_tries=1)
    assert search.tries[0].outcome == "found another train"
    found = search.found[0]
    assert_allclose(found.base.coefficients, coarse_base.coefficients, rtol=0, atol=1e-8)
    assert found.axisymmetric_rate < 0.0


def test_what_is_refused(coarse_base: Base) -> None:
    with pytest.raises(CaseError, match="most_tries = 0"):
        search_trains(coarse_base, most_tries=0)


@pytest.fixture(scope="module")
def searched(coarse_base: Base) -> BranchSearch:
    """A search that nobody made: two tries from one guess, a further train, and no more."""
    other = replace(coarse_base, cell_velocity=1.5, origin="made up")
    tries = (
        SearchTry("the resting shape", 5, "found another train", 1e-10, other),
        SearchTry("the resting shape", 0, "cells overlap", float("nan"), None),
    )
    found = (FoundTrain(other, "the resting shape", 0.7, -0.01),)
    return BranchSearch(coarse_base, tries, found)


def test_statements(searched: BranchSearch) -> None:
    assert searched.statement == "1 further steady train was found in 2 tries from 1 guess"
    none = replace(searched, found=(), tries=searched.tries[1:])
    assert none.statement == "no further steady train was found in 1 try from 1 guess"


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
    assert "try 2: from the resting shape: cells overlap" in printed.err
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
