"""Curves through folds, branches of steady trains, and the boundary of stability."""

import importlib
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain import Base, CaseError, Train, steady
from celltrain.analyses import branch as command
from celltrain.cli import main
from celltrain.continuation import (
    Branch,
    BranchPoint,
    CurveEnding,
    CurveLost,
    CurvePoint,
    Evaluation,
    NoSolution,
    Steps,
    branch,
    trace_curve,
)
from celltrain.continuation.branch import BEYOND
from celltrain.continuation.equations import known_point
from celltrain.contract import load
from celltrain.harmonics import Profile
from celltrain.proximity.meridian import streamwise_gap
from celltrain.results import save
from celltrain.steady.parameters import parameter_value

STEPS = Steps(first=0.1, largest=0.2, tolerance=1e-10)


def circle(unknowns: np.ndarray, _: None) -> Evaluation[None]:
    """x^2 + y^2 + z^2 = 1 and z = x/2, an ellipse in the plane of x and y."""
    x, y, z = unknowns
    residual = np.array([x * x + y * y + z * z - 1.0, z - 0.5 * x])
    jacobian = np.array([[2 * x, 2 * y, 2 * z], [-0.5, 0.0, 1.0]])
    return Evaluation(residual, jacobian, float(np.abs(residual).max()), None)


def followed(count: int, direction: list[float]) -> list[CurvePoint[None]]:
    start = np.array([0.2, 1.1, 0.0])
    points = trace_curve(circle, start, np.array(direction), None, STEPS)
    return [point for point, _ in zip(points, range(count), strict=False)]


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_curve_is_followed_through_its_folds(sign: float) -> None:
    points = followed(60, [sign, 0.0, 0.0])
    places = np.stack([point.unknowns for point in points])
    for place in places:
        assert np.abs(circle(place, None).residual).max() < 1e-10
    # Round and round: each coordinate rises and falls again, and neighbours are a step apart.
    assert np.sign(points[0].tangent[0]) == sign
    turned = np.unwrap(np.arctan2(places[:, 1], places[:, 0]))
    assert (np.diff(turned) * -sign > 0.0).all()
    assert abs(turned[-1] - turned[0]) > 2 * np.pi
    apart = np.linalg.norm(np.diff(places, axis=0), axis=1)
    steps = np.array([point.step for point in points[1:]])
    assert_allclose(apart, steps, rtol=2e-2)
    assert steps.max() <= STEPS.largest
    for point in points:
        assert_allclose(circle(point.unknowns, None).jacobian @ point.tangent, 0.0, atol=1e-10)
        assert_allclose(np.linalg.norm(point.tangent), 1.0, rtol=1e-12)


def test_a_curve_that_ends_is_followed_to_its_end() -> None:
    def half(unknowns: np.ndarray, state: None) -> Evaluation[None]:
        if unknowns[0] > 0.5:
            raise NoSolution("beyond the end")
        return circle(unknowns, state)

    curve = trace_curve(half, np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0]), None, STEPS)
    found: list[float] = []
    with pytest.raises(CurveLost, match=r"shorter than 0.0001"):
        found.extend(point.unknowns[0] for point in curve)
    assert (np.diff(found) > 0.0).all()
    assert_allclose(found[-1], 0.5, atol=1e-3)


def test_no_solution_nearby_is_told() -> None:
    def none(unknowns: np.ndarray, _: None) -> Evaluation[None]:
        residual = np.array([1.0 + float(unknowns @ unknowns)])
        return Evaluation(residual, 2.0 * unknowns[None], float(residual[0]), None)

    with pytest.raises(CurveLost, match="near the start"):
        next(trace_curve(none, np.ones(2), np.ones(2), None, STEPS))


@pytest.fixture(scope="module")
def single(coarse_base: Base) -> Base:
    return replace(coarse_base, train=coarse_base.train.changed(cells=1))


@pytest.mark.parametrize(
    ("parameter", "to", "largest"),
    [
        ("shear_modulus", 1.6, 0.15),
        ("capillary_number", 1.0, 0.1),
        ("reduced_volume", 0.72, 0.05),
        ("diameter", 6.8, 0.04),
    ],
)
def test_a_branch_consists_of_steady_trains(
    single: Base, parameter: str, to: float, largest: float
) -> None:
    found = branch(single, parameter, to=to, steps=Steps(first=largest / 1.5, largest=largest))
    assert found.ending.kind == "reached"
    values = [point.value for point in found.points]
    first = parameter_value(single.train, parameter)
    assert len(values) >= 4
    assert (np.diff(values) > 0.0).all()
    assert_allclose([values[0], values[-1]], [first, to], rtol=1e-14)
    assert found.folds == ()
    for point in found.points:
        assert point.base.residual < 1e-9
        assert parameter_value(point.base.train, parameter) == pytest.approx(point.value, rel=1e-14)
    inside = found.points[2].base
    again = steady(inside.train, start=single, estimate_error=False)
    assert_allclose(inside.coefficients, again.coefficients, rtol=0, atol=1e-8)
    assert_allclose(inside.cell_velocity, again.cell_velocity, rtol=0, atol=1e-9)
    assert abs(again.cell_velocity - single.cell_velocity) > 1e-4


def test_what_was_found_of_a_branch_is_kept(single: Base) -> None:
    seen: list[BranchPoint] = []

    def interrupt(point: BranchPoint) -> None:
        seen.append(point)
        if len(seen) == 2:
            raise KeyboardInterrupt

    found = branch(single, "packing", to=0.28, steps=Steps(first=0.02), progress=interrupt)
    assert found.ending.kind == "interrupted"
    assert found.points == tuple(seen)
    assert seen[1].value < seen[0].value == 0.3
    one = branch(single, "packing", to=0.28, steps=Steps(first=0.02), most_points=1)
    assert one.ending.kind == "enough"


def test_a_branch_ends_where_the_membrane_crosses_itself(
    single: Base, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Trains that do need a high degree; here those of another gap stand for them.
    limit = 0.999 * single.gap
    period = single.train.period

    def crosses(profile: Profile) -> bool:
        return streamwise_gap(profile, period) < limit

    monkeypatch.setattr(
        importlib.import_module("celltrain.continuation.branch"), "crosses_itself", crosses
    )
    found = branch(single, "diameter", to=0.9 * single.train.tube.diameter, steps=Steps(first=0.02))
    assert found.ending.kind == "lost"
    assert re.search(r"at diameter = [\d.]+ the membrane crosses itself", found.ending.message)
    assert found.points
    assert all(not crosses(point.base.profile) for point in found.points)


def test_what_was_found_is_in_the_file_of_an_interrupted_command(
    single: Base, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[str] = []

    def log(self: object, message: str) -> None:
        said.append(message)
        if sum(each.startswith("packing = ") for each in said) == 2:
            raise KeyboardInterrupt

    monkeypatch.setattr("celltrain.cli.progress.Reporter.log", log)
    start, path = save(single, tmp_path / "single.nc"), tmp_path / "branch.nc"
    words = ["--start", str(start), "--along", "packing", "--to", "0.28", "-o", str(path)]
    assert main(["branch", *words, "--quiet"]) == 130
    kept = load(path)
    assert isinstance(kept, Branch)
    assert kept.ending.kind == "interrupted"
    assert len(kept.points) == 2


def test_a_branch_ends_where_cells_nearly_touch(
    single: Base, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Far from where it would end for all users, to be quick.
    # The package's `branch` is the function.
    module = importlib.import_module("celltrain.continuation.branch")
    monkeypatch.setattr(module, "MOST_WORK", 1.5)
    steps = Steps(first=0.3, largest=0.3)
    found = branch(single, "packing", to=1.5, steps=steps, most_points=30)
    assert found.ending.kind == "lost"
    last = found.points[-1]
    assert 0.3 < last.value < 1.5
    words = (
        rf"the last train is at packing = {last.value:.6g}: the cells are \S+ r0 from each other"
    )
    assert re.match(words, found.ending.message)
    known = known_point(single).state.flow.rules.work
    works = [known_point(point.base).state.flow.rules.work / known for point in found.points]
    assert max(works[:-1]) <= 1.5 < works[-1] <= 1.5 * BEYOND


def test_branches_that_are_refused(single: Base) -> None:
    with pytest.raises(CaseError, match=r"parameter = 'viscosity_ratio'.*diameter, packing"):
        branch(single, "viscosity_ratio", to=2.0)
    with pytest.raises(CaseError, match="parameter = 'cells'"):
        branch(single, "cells", to=2.0)
    for beyond in (3.0, 8.0):
        with pytest.raises(CaseError, match=rf"packing = {beyond:g} .* allowed: > 0 and < \d\."):
            branch(single, "packing", to=beyond)
    with pytest.raises(CaseError, match=r"to = 0.3 is not allowed"):
        branch(single, "packing", to=0.3)


@pytest.fixture(scope="module")
def made_up(single: Base) -> Branch:
    """A branch with a fold, of trains that nobody computed."""
    values, slopes = [1.2, 1.4, 1.5, 1.3], [1.0, 0.5, -0.3, -1.0]
    points = tuple(
        BranchPoint(replace(single, cell_velocity=1.5 + 0.1 * i), value, slope, None)
        for i, (value, slope) in enumerate(zip(values, slopes, strict=True))
    )
    return Branch("shear_modulus", points, CurveEnding("lost", "the step became too short"))


def test_command_begins_at_a_flow_of_a_strength(
    made_up: Branch, single: Base, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The capillary number is no leaf, but changes all moduli.
    asked: list[Train] = []

    def found(base: Base, along: str, **_: object) -> Branch:
        asked.append(base.train)
        return made_up

    monkeypatch.setattr(command, "steady", lambda train, **_: replace(single, train=train))
    monkeypatch.setattr(command, "follow", found)
    case = ["branch", "--diameter", "6", "--packing", "0.3", "--degree", "6", "--quiet", "--json"]
    assert main([*case, "--along", "capillary_number", "--from", "1.5", "--to", "2"]) == 3
    assert_allclose(asked[0].cell.capillary_number, 1.5, rtol=1e-14)
    default = Train(diameter=6, packing=0.3).cell
    ratio = default.dilatation_modulus / default.shear_modulus
    assert_allclose(asked[0].cell.dilatation_modulus, ratio / 1.5, rtol=1e-14)


def test_command(
    made_up: Branch,
    single: Base,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    asked: list[tuple[float, float]] = []

    def found(base: Base, along: str, *, to: float, **_: object) -> Branch:
        asked.append((base.train.leaf(along), to))
        return made_up

    monkeypatch.setattr(command, "steady", lambda train, **_: replace(single, train=train))
    monkeypatch.setattr(command, "follow", found)
    case = ["branch", "--diameter", "6", "--packing", "0.3", "--degree", "6", "--quiet"]
    along = ["--along", "shear_modulus", "--from", "1.25", "--to", "1.5"]
    path = tmp_path / "branch.nc"
    files = ["-o", str(path), "--plot", str(tmp_path)]
    # What there is of the branch is kept; the status says that it could not be followed further.
    assert main([*case, *along, *files, "--json"]) == 3
    content = json.loads(capsys.readouterr().out)
    assert asked == [(1.25, 1.5)]
    assert [point["value"] for point in content["points"]] == [p.value for p in made_up.points]
    assert content["folds"] == [1]
    assert content["ending"] == {"kind": "lost", "message": "the step became too short"}
    assert load(path) == made_up
    assert sorted(each.name for each in tmp_path.iterdir()) == ["branch.nc", "branch.png"]
    assert main([*case, *along]) == 3
    printed = capsys.readouterr().out
    assert "fold" in printed
    assert "the step became too short" in printed


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--along", "cells", "--to", "2"], "along = 'cells' is not allowed"),
        (["--along", "packing", "--to", "3"], "packing = 3 is not allowed"),
        (["--along", "packing", "--from", "0.3", "--to", "0.3"], "to = 0.3 is not allowed"),
        (["--along", "packing", "--from", "-1", "--to", "0.3"], "packing = -1"),
    ],
)
def test_command_refuses(
    arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["branch", "--diameter", "6", "--packing", "0.2", *arguments]) == 2
    assert words in capsys.readouterr().err
