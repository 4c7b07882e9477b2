"""Without the extra `simulations` the main job works, and what needs it says so in one line."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

#: A process in which nothing of the extra can be imported.
PROGRAM = """
import sys
for name in ("jax", "jaxlib", "equinox"):
    sys.modules[name] = None
from celltrain.cli import main
sys.exit(main(sys.argv[1:]))
"""
MESSAGE = "python -m pip install 'celltrain[simulations]'"


def run(*arguments: str, folder: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", PROGRAM, *arguments]
    wide = {**os.environ, "COLUMNS": "200"}
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, env=wide)


@pytest.fixture(scope="module")
def computed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A result that was computed without it."""
    folder = tmp_path_factory.mktemp("without")
    case = ["--diameter", "6", "--packing", "0.2", "--cells", "2", "--degree", "8"]
    done = run("stability", *case, "-o", "train.nc", folder=folder)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.mark.slow
def test_its_result_is_shown_drawn_and_started_from(computed: Path) -> None:
    shown = run("show", "train.nc", folder=computed)
    assert shown.returncode == 0
    assert "growth rate" in shown.stdout
    assert run("plot", "train.nc", "-o", "again", folder=computed).returncode == 0
    assert (computed / "again" / "spectrum.png").is_file()
    assert run("base", "train.nc", "--packing", "0.21", folder=computed).returncode == 0


@pytest.mark.parametrize(
    "arguments",
    [
        ["evolve", "train.nc", "--until", "1", "-o", "run.nc"],
        ["streamlines", "train.nc", "-o", "flow.nc"],
        ["mechanisms", "train.nc", "-o", "flow.nc"],
    ],
    ids=lambda arguments: arguments[0],
)
def test_what_needs_it_says_so_at_once(computed: Path, arguments: list[str]) -> None:
    done = run(*arguments, folder=computed)
    assert done.returncode == 2
    assert not done.stdout
    [line] = done.stderr.splitlines()
    assert line.startswith("celltrain: ")
    assert line.endswith(MESSAGE)
    assert not (computed / arguments[-1]).exists()


@pytest.mark.parametrize(
    "name", ["celltrain.evolve", "celltrain.evolution.follow", "celltrain.diagnostics.cell_moments"]
)
def test_in_python_too(name: str, tmp_path: Path) -> None:
    package, _, attribute = name.rpartition(".")
    program = PROGRAM.split("from celltrain.cli")[0] + f"from {package} import {attribute}"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    last = done.stderr.splitlines()[-1]
    assert last.startswith("celltrain.extras.MissingExtra: ")
    assert last.endswith(MESSAGE)
