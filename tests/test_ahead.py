"""Loops that another process compiles: which, when, and that they are those that are wanted."""

import os
import subprocess
import sys
import threading
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numba
import numpy as np
import pytest
from test_repulsion import placed, sphere

from celltrain import Train
from celltrain.analyses.simulation import Simulation
from celltrain.compiled import ahead
from celltrain.compiled.block_loops import CLOSE_TYPES, FACING_TYPES
from celltrain.compiled.loops import CLOSE_FORCES, NEAREST, OWN_DOUBLE_LAYER, STRESSLET_PAIRS
from celltrain.compiled.nearest_search import NEAREST_TYPES
from celltrain.contract.progress import Silent
from celltrain.proximity import film_points, nearest, own_sides
from celltrain.proximity.film_points import film_grid

DEGREE = 6
ON_HOST = ["facing_on_host", "nearest_on_host", "close_on_host"]


class Processes:
    """Processes that are asked for in a folder where Numba keeps what the test puts there."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.commands: list[list[str]] = []
        self._folder = folder
        self._patch = monkeypatch
        monkeypatch.setattr(ahead, "_begun", threading.Event())
        monkeypatch.setattr(ahead, "_processors", lambda: 2)
        monkeypatch.setattr(ahead.atexit, "register", lambda *_: None)
        monkeypatch.setattr(ahead.subprocess, "Popen", self.begin)
        self.keep_in(str(folder))

    def begin(self, command: list[str], **_: Any) -> SimpleNamespace:
        self.commands.append(command)
        return SimpleNamespace(wait=lambda: 0)

    def keep_in(self, folder: str | None) -> None:
        cache = SimpleNamespace(cache_path=folder)
        self._patch.setattr(ahead, "help_with", SimpleNamespace(_cache=cache))

    def keep(self, *names: str) -> None:
        for name in names:
            (self._folder / f"{name}-12.py311.nbi").touch()

    def names(self) -> list[list[str]]:
        begin = [sys.executable, "-P", "-m", "celltrain.compiled.ahead"]
        assert all(each[:4] == begin for each in self.commands)
        return [each[4:] for each in self.commands]


@pytest.fixture
def processes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Processes:
    return Processes(tmp_path, monkeypatch)


@pytest.mark.parametrize(
    ("ratio", "names"), [(1.0, []), (5.0, [OWN_DOUBLE_LAYER, STRESSLET_PAIRS])]
)
def test_what_a_simulation_wants_is_begun_once(
    processes: Processes, ratio: float, names: list[str]
) -> None:
    for _ in range(2):
        ahead.compile_ahead(ratio)
    assert processes.names() == [[*names, NEAREST, CLOSE_FORCES, *ON_HOST]]


def test_what_is_kept_is_left_out(processes: Processes) -> None:
    processes.keep("nearest_loop._nearest_handler", "block_loops.facing_on_host")
    # Of another one's name.
    processes.keep("own_double_layer_loop._own_double_layer")
    ahead.compile_ahead(5.0)
    kept = [NEAREST, "facing_on_host"]
    whole = [OWN_DOUBLE_LAYER, STRESSLET_PAIRS, NEAREST, CLOSE_FORCES, *ON_HOST]
    assert processes.names() == [[each for each in whole if each not in kept]]


def test_nothing_is_begun_where_it_is_of_no_use(
    processes: Processes, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(ahead, "_processors", lambda: 1)
        ahead.compile_ahead(1.0)
    for python in (None, ""):
        with monkeypatch.context() as patch:
            patch.setattr(sys, "executable", python)
            ahead.compile_ahead(1.0)
    with monkeypatch.context() as patch:
        patch.setattr(sys, "frozen", True, raising=False)
        ahead.compile_ahead(1.0)
    processes.keep_in(None)
    ahead.compile_ahead(1.0)
    processes.keep_in(str(processes._folder))
    handlers = ("nearest_loop._nearest_handler", "close_loop._close_forces_handler")
    processes.keep(*handlers, "nearest_search.nearest_on_host")
    processes.keep("block_loops.facing_on_host", "block_loops.close_on_host")
    ahead.compile_ahead(1.0)
    assert processes.names() == []
    assert not ahead._begun.is_set()


def test_without_another_process_there_is_none(
    processes: Processes, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: Any, **__: Any) -> None:
        raise BlockingIOError("no more processes")

    monkeypatch.setattr(ahead.subprocess, "Popen", fail)
    ahead.compile_ahead(1.0)
    assert processes.names() == []


def test_the_process_compiles_what_it_is_told(tmp_path: Path) -> None:
    """Even where there lies a module of a name that Python has."""
    (tmp_path / "random.py").write_text("raise SystemExit(3)")
    kept = tmp_path / "kept"
    command = [sys.executable, "-P", "-m", ahead.__name__]
    settings: dict[str, Any] = {
        "cwd": tmp_path,
        "env": os.environ | {"NUMBA_CACHE_DIR": str(kept)},
        "stdin": subprocess.PIPE,
        "stderr": subprocess.PIPE,
    }
    with subprocess.Popen([*command, "facing_on_host"], **settings) as child:
        assert child.wait() == 0
    assert {each.name.split("-")[0] for each in kept.glob("*/*.nbi")} == {
        "block_loops.facing_on_host",
        "shared_work.help_with",
    }
    with subprocess.Popen([*command, "facing"], **settings) as child:
        # Not `communicate`, which would end the child's input, and so the child.
        assert child.stderr is not None
        assert b"facing is none of" in child.stderr.read()


def test_the_process_ends_with_who_began_it() -> None:
    end = threading.Event()
    read, write = os.pipe()
    watch = threading.Thread(target=ahead._end_with, args=(read, end.set))
    watch.start()
    assert not end.wait(0.2)
    os.close(write)
    assert end.wait(10.0)
    watch.join()
    os.close(read)


def test_types_are_those_that_a_search_for_films_has(monkeypatch: pytest.MonkeyPatch) -> None:
    """Others would be compiled, and what is wanted again."""
    found: dict[str, tuple[Any, ...]] = {}
    for module, name in ((own_sides, ON_HOST[0]), (nearest, ON_HOST[1]), (film_points, ON_HOST[2])):
        function = getattr(module, name)

        def recorded(*given: Any, function: Any = function) -> Any:
            found[function.__name__] = tuple(numba.typeof(each) for each in given)
            return function(*given)

        monkeypatch.setattr(module, name, recorded)
    grid = film_grid(DEGREE)
    shapes = placed(sphere(DEGREE), (0.0, 0.0, 0.0), (0.0, 0.0, 2.01))
    points = grid.find(shapes, grid.coarse.surfaces(shapes), within=0.05, period=20.0)
    assert len(points.cell) > 0
    assert np.isfinite(points.distance).all()
    assert found == dict(zip(ON_HOST, (FACING_TYPES, NEAREST_TYPES, CLOSE_TYPES), strict=True))


def test_what_a_simulation_imports_compiles_no_loop() -> None:
    program = """
import sys
from celltrain.evolution import evolve
loops = [name for name in sys.modules if name.startswith("celltrain.compiled.")]
assert "celltrain.compiled.call_frame" in loops
assert not [name for name in loops if name.endswith("_loop")], loops
"""
    subprocess.run([sys.executable, "-c", program], check=True)


def test_a_simulation_has_its_loops_compiled_while_it_finds_the_train(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    class BegunError(Exception):
        """With the viscosity ratio."""

    def begin(ratio: float) -> None:
        raise BegunError(ratio)

    monkeypatch.setattr(ahead, "compile_ahead", begin)
    train = Train(diameter=6, packing=0.2, viscosity_ratio=5.0)
    with pytest.raises(BegunError, match="5"):
        Simulation(until=1.0).compute_into(train, None, Silent(), None)
