"""One contract of everything that is computed: an analysis is one file, and all else follows."""

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, make_dataclass, replace
from pathlib import Path
from typing import Annotated

import numpy as np
import pytest
from cyclopts import App
from numpy.testing import assert_allclose

from celltrain import Base, CaseError, load, save, steady
from celltrain.analyses.base import SteadyTrain
from celltrain.cli import main
from celltrain.cli.app import COMMANDS
from celltrain.cli.computations import command_of_many, settings_class
from celltrain.continuation import BoundaryPoint, CurveEnding, StabilityBoundary
from celltrain.contract import (
    Crew,
    InFolder,
    Kept,
    OfStability,
    Setting,
    Silent,
    analysis_named,
    commands,
    draw_all,
    kinds,
    presentation,
)
from celltrain.contract.catalogue import TAKEN
from celltrain.contract.documentation import page
from celltrain.stability import Stability
from celltrain.stability.infinite import WaveMode

DOCUMENTATION = Path(__file__).parents[1] / "docs" / "diagnostics.md"
# A diagnostic of one's own: everything about it in one file.
OWN = '''\
"""How far a train is from standing still."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar

from matplotlib.figure import Figure
from rich.console import Console

from celltrain.contract import Draw, OfStability, Progress, Setting
from celltrain.contract.tables import quantities_table
from celltrain.parameters import CaseError, Train
from celltrain.quantities import Quantity, Record
from celltrain.stability import Stability
from celltrain.stability.infinite import WaveMode
from celltrain.steady import Base


@dataclass(frozen=True, eq=False)
class Slip(Record):
    """The slip of a train."""

    kind: ClassVar[str] = "slip"
    title: ClassVar[str] = "slip of a steady train"

    base: Base
    slip: Annotated[
        float, Quantity("s", "U", "velocity beyond the mean one", equation="s = U_c - 1")
    ]
    times: Annotated[float, Quantity("n", "1", "number of times")]


@dataclass(frozen=True, kw_only=True)
class TrainSlip(OfStability[Slip]):
    """Compute how far a train is ahead of the fluid."""

    result = Slip

    times: Annotated[float, Setting("Number of times.", "numbers > 0")] = 1.0

    def check(self, train: Train) -> None:
        super().check(train)
        if not self.times > 0.0:
            raise CaseError(f"times = {self.times:g} is not allowed; allowed: numbers > 0")

    def of(self, dynamics: Stability, progress: Progress) -> Slip:
        progress.log("slipping")
        return Slip(dynamics.base, self.times * (dynamics.base.cell_velocity - 1.0), self.times)

    @classmethod
    def report(cls, result: Slip, console: Console) -> None:
        console.print(quantities_table("Slip", result, {"slip": ".4f"}))

    @classmethod
    def pictures(cls, result: Slip) -> Mapping[str, Draw]:
        def draw():
            figure = Figure()
            figure.subplots().plot([0.0, result.slip])
            return figure

        return {"slip": draw}
'''


def test_the_page_of_documentation_says_what_the_analyses_say() -> None:
    assert DOCUMENTATION.read_text(encoding="utf-8") == page()


def test_every_analysis_is_a_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    text = capsys.readouterr().out
    for name in commands():
        assert f"│ {name} " in text
        analysis = analysis_named(name)
        if issubclass(analysis, InFolder):
            assert name not in kinds()
            continue
        assert (analysis.command or analysis.result.kind) == name
        assert analysis.result.kind in kinds()


@pytest.mark.parametrize("name", ["base", "sweep"])
def test_a_command_without_settings_lists_none(name: str, capsys) -> None:
    assert main([name, "--help"]) == 0
    assert re.findall(r"[A-Z]+OPTIONS", capsys.readouterr().out) == []


def test_what_is_not_there_is_told() -> None:
    with pytest.raises(KeyError, match="there is no analysis 'riddle'; there are: base, boundary"):
        analysis_named("riddle")
    with pytest.raises(KeyError, match="there is no kind of result 'riddle'"):
        presentation("riddle")


@pytest.mark.slow
def test_a_diagnostic_of_ones_own_is_one_file(coarse_base: Base, tmp_path: Path) -> None:
    """Its command, options, messages, file, report, JSON, picture, start and study column."""
    folder = tmp_path / "own"
    folder.mkdir()
    (folder / "slip.py").write_text(OWN)

    def celltrain(*arguments: object, status: int = 0) -> subprocess.CompletedProcess[str]:
        program = "import sys; from celltrain.cli import main; sys.exit(main())"
        done = subprocess.run(
            [sys.executable, "-c", program, *map(str, arguments)],
            env=os.environ | {"CELLTRAIN_ANALYSES": str(folder)},
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == status, done.stderr
        return done

    assert "slip" in celltrain("--help").stdout
    text = " ".join(celltrain("slip", "--help").stdout.replace("│", " ").split())
    assert "Number of times. (allowed: numbers > 0) [default: 1.0]" in text
    start = save(coarse_base, tmp_path / "start.nc")
    assert "times = -1" in celltrain("slip", start, "--times", "-1", status=2).stderr
    done = celltrain("slip", start, "--times", "2", "-o", "slip.nc", "--plot", "drawn", "--json")
    slip = 2.0 * (coarse_base.cell_velocity - 1.0)
    content = json.loads(done.stdout)
    assert_allclose(content["slip"], slip, rtol=1e-9)
    assert content["kind"] == "slip"
    assert "slipping" in done.stderr
    assert (tmp_path / "drawn" / "slip.png").stat().st_size > 5_000
    assert f"{slip:.4f}" in celltrain("show", "slip.nc").stdout
    assert "slip.png" in celltrain("plot", "slip.nc", "-o", "again", "--quiet").stdout
    again = json.loads(celltrain("base", "--start", "slip.nc", "--json", "--quiet").stdout)
    assert_allclose(again["cell_velocity"], coarse_base.cell_velocity, rtol=1e-9)
    study = "[case]\npacking = 0.3\ncells = 2\ndegree = 6\n[axes]\ndiameter = [6.0]\n"
    (tmp_path / "study.toml").write_text(study + '[compute]\nanalyses = ["slip"]\n')
    table = celltrain("sweep", "study.toml", "--workers", "1", "--quiet").stdout
    assert "slip_slip" in table
    with pytest.raises(ValueError, match="kind 'slip'; known are"):
        load(tmp_path / "slip.nc")


def test_files_of_ones_own_that_are_wrong_are_told(tmp_path: Path) -> None:
    (tmp_path / "broken.py").write_text("class")
    (tmp_path / "empty.py").write_text("x = 1\n")
    program = "import sys; from celltrain.cli import main; sys.exit(main())"
    done = subprocess.run(
        [sys.executable, "-c", program, "--help"],
        env=os.environ | {"CELLTRAIN_ANALYSES": str(tmp_path), "COLUMNS": "200"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert "broken" in done.stdout
    assert done.stdout.count("Cannot be used") == 2


def test_results_go_through_files_reports_and_pictures(
    make_stability: Callable[..., Stability],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    path = save(make_stability(), tmp_path / "result.nc")
    assert main(["show", str(path)]) == 0
    printed = capsys.readouterr().out
    assert "Leading modes" in printed
    assert main(["show", str(path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["kind"] == "stability"
    assert main(["plot", str(path), "--quiet"]) == 0
    drawn = sorted(each.stem for each in (tmp_path / "result-pictures").iterdir())
    assert drawn == ["base_train", "leading_mode", "profile", "spectrum", "transient_mode"]
    assert main(["show", str(tmp_path / "missing.nc")]) == 2
    assert "there is no such file" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["pseudospectrum", "neighbours", "mechanisms", "transient"])
def test_what_goes_on_from_a_stability(
    name: str, coarse_stability: Stability, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Saved, loaded, shown, drawn, in JSON, and started from."""
    settings = {"pseudospectrum": {"points": 5}, "transient": {"until": 2.0}}.get(name, {})
    analysis = analysis_named(name)(**settings)
    assert isinstance(analysis, OfStability)
    analysis.check(coarse_stability.base.train)
    result = analysis.of(coarse_stability, Silent())
    path = save(result, tmp_path / "result.nc")
    assert load(path) == result
    assert presentation(name).steady_train(load(path)) == coarse_stability.base
    assert main(["show", str(path)]) == 0
    assert "D = " in capsys.readouterr().out
    assert main(["show", str(path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["kind"] == name
    assert all(drawn.stat().st_size > 10_000 for drawn in draw_all(result, tmp_path))


def test_a_boundary_survives_its_file(
    coarse_base: Base, coarse_stability: Stability, tmp_path: Path
) -> None:
    size = len(coarse_stability.transient.vector)
    mode = WaveMode(0.0, 0.1, 1, 1.5, np.ones(size, complex), np.ones(size, complex))
    points = (BoundaryPoint(coarse_base, mode, np.array([0.1, -0.2])),) * 2
    result = StabilityBoundary(points, CurveEnding("enough", "2 points were found"))
    assert load(save(result, tmp_path / "boundary.nc")) == result
    assert presentation("boundary").status(result) == 0
    lost = StabilityBoundary(points, CurveEnding("lost", "the step became too short"))
    assert presentation("boundary").status(lost) == 3
    assert lost != result


def test_a_picture_that_fails_takes_nothing_with_it(
    make_base: Callable[..., Base],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    import celltrain.pictures
    from celltrain.analyses import base as command

    def fail(*_: object) -> Path:
        raise RuntimeError("no font was found")

    base = make_base()
    monkeypatch.setattr(celltrain.pictures, "draw_base_train", fail)
    monkeypatch.setattr(command, "steady", lambda train, **_: base)
    case = ["base", "--diameter", "6", "--packing", "0.2", "--json", "--quiet"]
    path, pictures = tmp_path / "base.nc", tmp_path / "pictures"
    assert main([*case, "-o", str(path), "--plot", str(pictures)]) == 4
    printed = capsys.readouterr()
    assert json.loads(printed.out)["cell_velocity"] == base.cell_velocity
    assert "base_train.png' could not be drawn: no font was found" in printed.err
    assert load(path) == base
    assert [each.name for each in pictures.iterdir()] == ["profile.png"]


def test_a_file_that_cannot_be_written_is_told_after_the_result(
    make_base: Callable[..., Base],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    from celltrain.analyses import base as command
    from celltrain.results import replace

    base = make_base()
    monkeypatch.setattr(command, "steady", lambda train, **_: base)

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(replace.os, "replace", full)
    path = tmp_path / "base.nc"
    case = ["base", "--diameter", "6", "--packing", "0.2", "--quiet"]
    assert main([*case, "-o", str(path)]) == 4
    printed = capsys.readouterr()
    assert f"{base.cell_velocity:.5f}" in printed.out
    assert "could not be written: No space left on device" in printed.err
    assert list(tmp_path.iterdir()) == []


def test_case_and_start_are_not_both_results(
    make_base: Callable[..., Base], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = str(save(make_base(), tmp_path / "base.nc"))
    assert main(["base", path, "--start", path]) == 2
    assert "both hold a steady train" in capsys.readouterr().err


def test_a_study_is_no_start(tmp_path: Path) -> None:
    from celltrain.study import StudyResult

    with pytest.raises(CaseError, match="it holds numbers only"):
        presentation("study").steady_train(StudyResult.__new__(StudyResult))


def test_pictures_are_named_alike(make_base: Callable[..., Base], tmp_path: Path) -> None:
    found = [path.name for path in draw_all(make_base(), tmp_path)]
    assert found == ["base_train.png", "profile.png"]


def test_a_steady_train_goes_on_from_any_result(coarse_stability: Stability) -> None:
    again = steady(coarse_stability.base.train, start=coarse_stability.base)
    assert np.allclose(again.coefficients, coarse_stability.base.coefficients, atol=1e-8)


def test_a_case_file_in_si_has_both_ends_of_a_branch_in_si(
    coarse_base: Base, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from celltrain.analyses import branch as command
    from celltrain.continuation import Branch, BranchPoint

    asked: list[tuple[float, float]] = []

    def follow(base: Base, along: str, *, to: float, **_: object) -> Branch:
        asked.append((base.train.leaf(along), to))
        return Branch(along, (BranchPoint(base, 1.0, 1.0, None),), CurveEnding("enough", "enough"))

    monkeypatch.setattr(command, "steady", lambda train, **_: replace(coarse_base, train=train))
    monkeypatch.setattr(command, "follow", follow)
    path = tmp_path / "si.toml"
    path.write_text('units = "SI"\n[tube]\ndiameter = 16.8e-6\n[train]\npacking = 0.3\n')
    ends = ["--along", "diameter", "--from", "17.36e-6", "--to", "18.2e-6"]
    assert main(["branch", str(path), "--degree", "6", *ends, "--quiet"]) == 0
    assert_allclose(asked, [(6.2, 6.5)])


def test_names_that_are_taken(tmp_path: Path) -> None:
    assert set(TAKEN) == {*COMMANDS} - {*commands()}
    (tmp_path / "show.py").write_text(OWN)
    (tmp_path / "bytes.py").write_bytes(b"\xff\xfe\x00class")
    (tmp_path / ".#own.py").symlink_to("what an editor keeps beside an open file")
    folders = os.pathsep.join([str(tmp_path), str(tmp_path / "nowhere")])
    program = (
        "import sys; from celltrain.cli import main; from celltrain.contract import commands;"
        " print(commands()); sys.exit(main())"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, "show", "missing.nc"],
        env=os.environ | {"CELLTRAIN_ANALYSES": folders},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert "'bytes'" in done.stdout
    assert ".#own" not in done.stdout
    assert "there is a command or a kind of result 'show'" in done.stderr
    assert "nowhere' is not there" in done.stderr
    assert "file = 'missing.nc' cannot be read" in done.stderr


def test_what_computes_many_cases_is_a_command_with_a_folder(tmp_path: Path, capsys) -> None:
    @dataclass(frozen=True, kw_only=True)
    class Cubes(InFolder):
        """Count the cells of a cube."""

        argument = "edge"

        edge: Annotated[int, Setting("Cells along an edge.")]
        hollow: Annotated[bool, Setting("Count the faces' alone.")] = False

        def check(self) -> None:
            if self.edge < 1:
                raise CaseError(f"edge = {self.edge} is not allowed; allowed: >= 1")

        @property
        def folder(self) -> Path:
            """Cube, in this folder."""
            return tmp_path / "cube"

        def compute(self, folder: Path, crew: Crew) -> Kept:
            cells = self.edge**3 - (max(self.edge - 2, 0) ** 3 if self.hollow else 0)
            words = f"{cells} cells, anew: {crew.retry}\n"
            return Kept(words, {"cells": cells}, {"cells.txt": words}, {}, status=3)

    app = App(result_action="return_value")
    app.command(command_of_many(Cubes), name="cubes")
    assert app(["cubes", "3", "--hollow", "--retry"]) == 3
    printed = capsys.readouterr()
    assert printed.out == "26 cells, anew: True\n"
    assert (tmp_path / "cube" / "cells.txt").read_text() == printed.out
    assert "cells.txt" in printed.err
    assert app(["cubes", "3", "--json", "-o", str(tmp_path / "other"), "--quiet"]) == 3
    assert json.loads(capsys.readouterr().out) == {"cells": 27}
    assert (tmp_path / "other" / "cells.txt").is_file()
    with pytest.raises(CaseError, match="edge = 0"):
        app(["cubes", "0"])
    with pytest.raises(TypeError, match="'retry' is an option already"):
        settings_class(make_dataclass("Again", [("retry", Annotated[bool, Setting("")], False)]))


def test_settings_of_ones_own_that_are_wrong_are_told() -> None:
    @dataclass(frozen=True, kw_only=True)
    class Plain(SteadyTrain):
        """Without a setting."""

        on: bool = True

    with pytest.raises(TypeError, match="'on' has no Setting"):
        settings_class(Plain)

    @dataclass(frozen=True, kw_only=True)
    class Taken(SteadyTrain):
        """With the name of an option of every case."""

        tolerance: Annotated[float, Setting("How exactly.")] = 1.0

    with pytest.raises(TypeError, match="'tolerance' is an option already"):
        settings_class(Taken)
