"""Loops that another process compiles: which, when, and that they are those that are wanted."""

import os
import subprocess
import sys
import threading
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from celltrain import Train, environment
from celltrain.analyses.simulation import Simulation
from celltrain.compiled import ahead
from celltrain.compiled.loops import LOOPS, OWN_DOUBLE_LAYER, STRESSLET_PAIRS
from celltrain.contract.progress import Silent


class Processes:
    """Processes that are asked for in a folder where Numba keeps what the test puts there."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.commands: list[list[str]] = []
        self._folder = folder
        self._patch = monkeypatch
        monkeypatch.setattr(ahead, "_begun", threading.Event())
        monkeypatch.setattr(ahead, "processors", lambda: 2)
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


@pytest.mark.parametrize("ratio", [1.0, 5.0])
def test_what_a_simulation_wants_is_begun_once(processes: Processes, ratio: float) -> None:
    for _ in range(2):
        ahead.compile_ahead(ratio)
    (names,) = processes.names()
    of_viscosity = {OWN_DOUBLE_LAYER.name, STRESSLET_PAIRS.name}
    assert set(LOOPS) - set(names) == (of_viscosity if ratio == 1.0 else set())
    # In this order they share most; this process begins with the last.
    assert names == [each for each in LOOPS if each in names]


def test_what_is_kept_is_left_out(processes: Processes) -> None:
    processes.keep("nearest_loop._nearest", "force_pair_loop._force_pairs", "facing_loop._facing")
    # Of a source that was changed afterwards.
    os.utime(processes._folder / "facing_loop._facing-12.py311.nbi", (0.0, 0.0))
    ahead.compile_ahead(5.0)
    assert processes.names() == [
        [
            "celltrain_stresslet_pairs",
            "celltrain_own_forces",
            "celltrain_own_double_layer",
            "celltrain_close_forces",
            "celltrain_spread",
            "celltrain_interpolate",
            "celltrain_facing",
        ]
    ]


def test_nothing_is_begun_where_it_is_of_no_use(
    processes: Processes, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(ahead, "processors", lambda: 1)
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
    processes.keep(*(f"{each.module.split('.')[-1]}._task" for each in LOOPS.values()))
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
    with subprocess.Popen([*command, STRESSLET_PAIRS.name], **settings) as child:
        assert child.wait() == 0
    assert {each.name.split("-")[0] for each in kept.glob("*/*.nbi")} == {
        "shared_work.help_with",
        "stresslet_pair_loop._stresslet_pairs",
    }
    with subprocess.Popen([*command, "nothing"], **settings) as child:
        # Not `communicate`, which would end the child's input, and so the child.
        assert child.stderr is not None
        assert b"nothing is none of" in child.stderr.read()


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


@pytest.mark.parametrize(("asked", "number"), [("3", 3), ("1", 1), ("0", None), ("many", None)])
def test_processors_are_as_many_as_xla_takes(
    asked: str, number: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("NPROC", raising=False)
    there = environment.processors()
    assert there >= 1
    monkeypatch.setenv("NPROC", asked)
    assert environment.processors() == (there if number is None else number)
