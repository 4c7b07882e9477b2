"""The command line: what is refused, how, and what goes where. Nothing is computed here."""

import itertools
import json
import math
import subprocess
import sys
import tomllib
from importlib import import_module
from types import SimpleNamespace

import numpy as np
import pytest

from celltrain.analyses import base as command
from celltrain.cli import compute, main
from celltrain.cli.app import COMMANDS
from celltrain.cli.progress import Reporter
from celltrain.contract import load
from celltrain.parameters import Train
from celltrain.results import save
from celltrain.steady import Base, Iteration

CASE = ["--diameter", "6", "--packing", "0.2"]


@pytest.mark.parametrize("command", ["stability", "base", "case"])
@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["--diameter", "-2", "--packing", "0.2"], ["diameter = -2", "> 0"]),
        (["--diameter", "6", "--packing", "0"], ["packing = 0", "> 0"]),
        (["--packing", "0.2"], ["diameter is missing"]),
        ([*CASE, "--cells", "0"], ["cells = 0", "1 to 10000"]),
        ([*CASE, "--cells", "2.6"], ["--cells", "2.6", "a whole number 1 to 10000"]),
        ([*CASE, "--degree", "4"], ["degree = 4", "6 to 64"]),
        ([*CASE, "--shear-modulus", "-1"], ["shear_modulus = -1", "> 0"]),
        ([*CASE, "--law", "hooke"], ["law = 'hooke'", "skalak or neo_hookean"]),
        (["--diameter", "six", "--packing", "0.2"], ["--diameter", "six", "a number > 0"]),
        (["--diamter", "6"], ["--diamter", "--diameter"]),
        ([*CASE, "--units", "CGS"], ["CGS", 'allowed: "dimensionless", "SI"']),
        (["missing.toml"], ["'missing.toml'", "cannot be read"]),
    ],
)
def test_bad_input(command, arguments, parts, capsys):
    assert main([command, *arguments]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert all(part in printed.err for part in parts), printed.err
    assert "Traceback" not in printed.err
    assert "pydantic" not in printed.err


@pytest.mark.parametrize("command", ["stability", "base"])
@pytest.mark.parametrize("degree", [[], ["--degree", "8"]])
def test_cells_that_have_no_room(command, degree, capsys):
    assert main([command, "--diameter", "1.0", "--packing", "0.2", *degree, "--quiet"]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert "diameter = 1 is not allowed" in printed.err
    assert "allowed: > 1.07" in printed.err
    assert main([command, "--diameter", "6", "--packing", "7", *degree, "--quiet"]) == 2
    assert "would overlap; allowed: > 0 and < 2.01" in capsys.readouterr().err


def test_unknown_key_in_a_case_file(tmp_path, capsys):
    path = tmp_path / "case.toml"
    path.write_text("[tube]\ndiamter = 6\n")
    assert main(["base", str(path)]) == 2
    assert "did you mean diameter" in capsys.readouterr().err


def test_azimuthal_numbers_are_within_the_degree(capsys):
    assert main(["stability", *CASE, "--degree", "12", "--azimuthal-numbers", "0", "13"]) == 2
    assert "azimuthal_numbers = 13" in capsys.readouterr().err
    assert main(["stability", *CASE, "--azimuthal-numbers", "0", "65"]) == 2
    assert "to the degree, at most 64" in capsys.readouterr().err
    assert main(["stability", *CASE, "--azimuthal-numbers", "1.5"]) == 2
    assert "1.5" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["stability", "base"])
def test_output_is_checked_before_anything_is_computed(command, tmp_path, capsys):
    outputs = {
        str(tmp_path / "missing" / "file.nc"): "is no folder",
        str(tmp_path): "no regular file",
        "/dev/null": "no regular file",
    }
    for path, reason in outputs.items():
        assert main([command, *CASE, "-o", path]) == 2
        message = capsys.readouterr().err
        assert path in message
        assert reason in message
    assert list(tmp_path.iterdir()) == []


def test_folder_for_pictures_is_checked_before_anything_is_computed(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    path = str(tmp_path / "file" / "pictures")
    assert main(["base", *CASE, "--plot", path]) == 2
    assert path in capsys.readouterr().err


def test_start_must_be_a_result(tmp_path, capsys):
    assert main(["base", *CASE, "--start", str(tmp_path / "missing.nc")]) == 2
    assert "missing.nc" in capsys.readouterr().err
    (tmp_path / "text.nc").write_text("no result")
    assert main(["base", *CASE, "--start", str(tmp_path / "text.nc")]) == 2
    assert "text.nc" in capsys.readouterr().err


def test_case_is_a_complete_case_file(tmp_path, capsys):
    assert main(["case", *CASE, "--degree", "16", "--polar-radial", "20"]) == 0
    text = capsys.readouterr().out
    expected = Train(diameter=6, packing=0.2, degree=16, polar_radial=20)
    assert text == expected.to_toml()
    resolution = tomllib.loads(text)["resolution"]
    assert (resolution["degree"], resolution["polar_radial"]) == (16, 20)
    assert "energy_order" not in resolution
    path = tmp_path / "case.toml"
    path.write_text(text)
    assert main(["case", str(path), "--packing", "0.5"]) == 0
    assert capsys.readouterr().out == expected.changed(packing=0.5).to_toml()


def test_a_case_need_not_have_a_degree(tmp_path, capsys):
    assert main(["case", *CASE]) == 0
    text = capsys.readouterr().out
    assert set(tomllib.loads(text)["resolution"]) == {"grading", "near_cutoff", "tolerance"}
    path = tmp_path / "case.toml"
    path.write_text(text)
    assert main(["case", str(path), "--degree", "16"]) == 0
    assert capsys.readouterr().out == Train(diameter=6, packing=0.2, degree=16).to_toml()


def test_options_in_si(capsys):
    assert main(["case", "--units", "SI", "--diameter", "16.8e-6", "--packing", "0.2"]) == 0
    assert capsys.readouterr().out == Train(diameter=6, packing=0.2).to_toml()


def test_every_leaf_is_an_option(capsys):
    assert main(["stability", "--help"]) == 0
    text = capsys.readouterr().out
    for leaf in Train(diameter=6, packing=0.2).leaves("SI"):
        assert f"--{leaf.replace('_', '-')}" in text
    words = " ".join(text.replace("│", " ").split())
    assert words.count("default: follows from the degree") == 5
    assert words.count("default: as the accuracy asks for") == 1


def test_exit_status_of_the_process():
    arguments = ["stability", "--diameter", "1", "--packing", "0.2"]
    result = subprocess.run(
        [sys.executable, "-m", "celltrain", *arguments],
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 2
    assert result.stdout == ""
    assert "> 1.07" in result.stderr


@pytest.fixture
def fake_base():
    """A base flow that nobody computed."""
    train = Train(diameter=6, packing=0.2, degree=6)
    return Base(
        train=train,
        coefficients=np.zeros((3, 36)),
        cell_velocity=1.5,
        gap=1.0,
        largest_radius=1.2,
        effective_viscosity=1.1,
        residual=1e-9,
        truncation_error=1e-4,
        velocity_error=1e-7,
        history=(
            Iteration("march", 1e-2, 0.5, 1.4),
            Iteration("newton", 1e-9, math.inf, 1.5),
        ),
        origin="made up",
        seconds={"compile": 0.1, "base": 0.2},
    )


def test_json_is_one_object_and_alone_on_standard_output(fake_base, monkeypatch, capsys):
    def steady(train, *, start=None, progress=None):
        print("something that a library prints")
        for iteration in fake_base.history:
            progress(iteration)
        return fake_base

    monkeypatch.setattr(command, "steady", steady)
    assert main(["base", *CASE, "--json"]) == 0
    printed = capsys.readouterr()
    content = json.loads(printed.out)
    assert content["cell_velocity"] == 1.5
    assert content["case"]["tube"]["diameter"] == 6
    assert [entry["step"] for entry in content["history"]] == [0.5, None]
    assert {"gap", "largest_radius", "effective_viscosity", "residual", "seconds"} <= set(content)
    assert "newton" in printed.err
    assert "library" in printed.err
    assert main(["base", *CASE, "--json", "--quiet"]) == 0
    assert "newton" not in capsys.readouterr().err


@pytest.mark.parametrize("output", [None, "train.nc"])
def test_no_convergence_saves_the_last_state(output, fake_base, monkeypatch, tmp_path, capsys):
    def fail(train, *, start=None, progress=None):
        raise compute.NotConverged("no steady train within 3 iterations", fake_base)

    monkeypatch.setattr(command, "steady", fail)
    monkeypatch.chdir(tmp_path)
    arguments = ["-o", output] if output else []
    assert main(["base", *CASE, "--json", *arguments]) == 3
    printed = capsys.readouterr()
    assert printed.out == ""
    assert "no steady train within 3 iterations" in printed.err
    assert "march" in printed.err
    last = "train.last.nc" if output else "celltrain-last.nc"
    assert [path.name for path in tmp_path.iterdir()] == [last]
    assert load(last).cell_velocity == 1.5


def test_start_gives_the_case_that_options_change(fake_base, monkeypatch, tmp_path, capsys):
    seen = []

    def steady(train, *, start=None, progress=None):
        seen.append((train, start))
        return fake_base

    monkeypatch.setattr(command, "steady", steady)
    path = tmp_path / "start.nc"
    save(fake_base, path)
    assert main(["base", "--start", str(path), "--packing", "0.5", "--json", "--quiet"]) == 0
    capsys.readouterr()
    train, start = seen[0]
    assert train == fake_base.train.changed(packing=0.5)
    assert start.train == fake_base.train


def test_interruption_is_told(monkeypatch, tmp_path, capsys):
    def interrupt(train, *, start=None, progress=None):
        raise KeyboardInterrupt

    monkeypatch.setattr(command, "steady", interrupt)
    path = tmp_path / "train.nc"
    path.write_text("an older result")
    assert main(["base", *CASE, "-o", str(path)]) == 130
    assert "interrupted" in capsys.readouterr().err
    assert path.read_text() == "an older result"


def test_each_commands_help_is_the_first_line_of_its_docstring(capsys):
    for name, (place, line) in COMMANDS.items():
        module, function = place.split(":")
        command = getattr(import_module(f"celltrain.cli.{module}"), function)
        assert command.__doc__.splitlines()[0] == line, name
    assert main(["--help"]) == 0
    text = " ".join(capsys.readouterr().out.replace("│", " ").split())
    for name, (_, line) in COMMANDS.items():
        assert f"{name} {line}" in text


def imported(program: str, *arguments: str) -> set[str]:
    """Which of the large libraries a program loads."""
    script = f"import sys\n{program}\nprint(*sys.modules, file=sys.stderr)"
    result = subprocess.run(
        [sys.executable, "-c", script, *arguments], capture_output=True, text=True, check=True
    )
    large = {"jax", "equinox", "numba", "scipy", "xarray", "matplotlib", "distributed"}
    return large & set(result.stderr.splitlines()[-1].split())


def test_what_commands_import():
    run = "from celltrain.cli import main\nassert main(sys.argv[1:]) == 0"
    assert imported(run, "--help") == set()
    assert imported(run, "--version") == set()
    assert imported(run, "case", *CASE) == set()
    program = "from celltrain.cli.computations import stability"
    assert not imported(program) & {"jax", "equinox", "matplotlib"}
    case = [*CASE, "--degree", "6", "--cells", "1", "--error-bars", "1", "--json", "--quiet"]
    assert not imported(run, "stability", *case) & {"jax", "equinox", "matplotlib"}


@pytest.mark.parametrize(
    ("seconds", "expected"), [(0.0, [10, 20]), (20.0, [3, 6, 9, 10, 13, 16, 19, 20, 23])]
)
def test_what_has_an_end_is_told_by_tenths_and_by_time(
    seconds: float,
    expected: list[int],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Of a hundred parts a line for each tenth, and where they take long for each minute."""
    now = itertools.count(0.0, seconds)
    clock = SimpleNamespace(monotonic=lambda: next(now))
    monkeypatch.setattr("celltrain.cli.progress.time", clock)
    with Reporter() as reporter:
        for done in range(1, 26):
            reporter.part("study", done, 100)
    told = capsys.readouterr().err.splitlines()
    assert told == [f"study: {done} of 100" for done in expected]
