"""The command of simulations: what it says, with which status it ends, what it refuses."""

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain import Stability, Train, save
from celltrain.analyses import simulation
from celltrain.cli import main
from celltrain.contract.status import ComputationFailed
from celltrain.evolution import Run, Status


@pytest.mark.slow
def test_the_command_simulates_and_goes_on(coarse_stability, tmp_path: Path, capsys) -> None:
    start, path = tmp_path / "start.nc", tmp_path / "run.nc"
    save(coarse_stability, start)
    arguments = ["evolve", str(start), "--degree", "6", "--disturbance", "random:2"]
    arguments += ["--amplitude", "0.2", "--until", "0.3", "--every", "0.1"]
    arguments += ["-o", str(path), "--json", "--quiet"]
    assert main(arguments) == 0
    printed = capsys.readouterr()
    summary = json.loads(printed.out)
    assert summary["ending"]["kind"] == "complete"
    assert summary["frames"] == 4
    assert_allclose(summary["eps"][0], 0.2, rtol=2e-2)
    assert printed.err == ""
    # It is not overwritten, unless that is asked for.
    assert main(arguments) == 2
    assert "--resume, or --overwrite" in capsys.readouterr().err
    again = ["evolve", "--resume", "-o", str(path), "--until", "1.2"]
    assert main(again) == 0
    printed = capsys.readouterr()
    assert "Simulation" in printed.out
    assert "r0/U per hour" in printed.err
    run = Run.load(path)
    assert_allclose(run.times, 0.1 * np.arange(13), atol=1e-12)
    # The linear dynamics of the start is in the file, too, and its prediction beside the result.
    assert isinstance(run.start, Stability)
    assert_allclose(run.frames["eps"], run.frames["eps_linear"], rtol=2e-2)


def test_exit_statuses_of_the_command(
    coarse_stability, tmp_path: Path, capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    start, path = tmp_path / "start.nc", tmp_path / "run.nc"
    save(coarse_stability, start)
    common = ["evolve", str(start), "--degree", "6", "-o", str(path), "--quiet"]
    common += ["--disturbance", "leading"]
    assert main([*common, "--until", "1", "--step-tolerance", "1e-30"]) == 3
    assert "needs steps below" in capsys.readouterr().err

    def interrupt(self: object, status: Status) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("celltrain.cli.progress.Reporter.step", interrupt)
    assert main([*common, "--until", "1", "--overwrite"]) == 130
    message = capsys.readouterr().err
    assert "interrupted" in message
    assert str(path) in message
    assert Run.load(path).steps == 1


@pytest.mark.parametrize(("source", "degree"), [("case", 8), ("start", 12)])
def test_the_degree_is_that_of_the_case_and_not_of_a_result(
    source: str, degree: int, coarse_stability, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    case, start = tmp_path / "case.toml", tmp_path / "start.nc"
    train = coarse_stability.base.train
    case.write_text(train.changed(degree=8).to_toml())
    save(coarse_stability, start)
    seen: list[int] = []

    def computed(self, train: Train, *_: object) -> None:
        seen.append(simulation._at_own_degree(train).degree)
        raise ComputationFailed("this is enough")

    monkeypatch.setattr(simulation.Simulation, "compute_into", computed)
    words = [str(case), "--start", str(start)] if source == "case" else [str(start)]
    options = ["--until", "1", "-o", str(tmp_path / "run.nc"), "--quiet"]
    assert main(["evolve", *words, *options, "--disturbance", "random"]) == 3
    assert seen == [degree]


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["--until", "1"], ["output is missing"]),
        (["-o", "{}/run.nc"], ["until is missing"]),
        (["-o", "{}/run.nc", "--until", "-1", "--disturbance", "random"], ["until = -1", "> 0"]),
        (["-o", "{}/missing/run.nc", "--until", "1"], ["is no folder"]),
        (["-o", "{}/run.nc", "--until", "1", "--disturbance", "worst"], ["'worst'", "transient"]),
        (
            ["-o", "{}/run.nc", "--until", "1", "--step-tolerance", "0"],
            ["step_tolerance = 0", "> 0"],
        ),
        (["-o", "{}/run.nc", "--resume"], ["a case is not allowed with --resume"]),
    ],
)
def test_what_the_command_refuses(arguments, parts, coarse_stability, tmp_path, capsys) -> None:
    start = tmp_path / "start.nc"
    save(coarse_stability, start)
    arguments = [each.format(tmp_path) for each in arguments]
    assert main(["evolve", str(start), *arguments]) == 2
    message = capsys.readouterr().err
    assert all(part in message for part in parts), message
    assert [each.name for each in tmp_path.iterdir()] == ["start.nc"]
    assert main(["evolve", "--resume", "-o", str(tmp_path / "none.nc")]) == 2
    assert "no such file" in capsys.readouterr().err
