"""A process that goes from train to train does not keep all of its compiled programs."""

import importlib
import os
from collections.abc import Callable
from pathlib import Path

import jax
import jax.numpy as jnp
import pytest

from celltrain import Train, programs, stability, steady
from celltrain.programs import forget_many_programs

MOST_AREAS, LEAST_GROWTH = 1000, 2**24
Process = Callable[[int, int], None]


@pytest.fixture
def process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Process:
    """Sets how many memory areas and bytes the system says that this process takes."""
    most = tmp_path / "most"
    most.write_text(f"{MOST_AREAS}\n")
    monkeypatch.setattr(programs, "_MOST_AREAS", most)
    monkeypatch.setattr(programs, "_PROCESS", tmp_path)
    monkeypatch.setattr(programs, "_last", None)
    monkeypatch.setattr(programs, "LEAST_GROWTH", LEAST_GROWTH)
    # So that a process's share of the memory is next to nothing.
    monkeypatch.setattr("os.cpu_count", lambda: 2**40)

    def takes(areas: int, memory: int) -> None:
        (tmp_path / "maps").write_text("an area\n" * areas)
        (tmp_path / "statm").write_text(f"7 {memory // os.sysconf('SC_PAGE_SIZE')} 7 7 7 7 7\n")

    takes(100, 2**30)
    return takes


@pytest.mark.parametrize("grown", [(MOST_AREAS // 2, 0), (0, LEAST_GROWTH)])
def test_programs_are_forgotten_when_they_are_many(
    process: Process, grown: tuple[int, int]
) -> None:
    compiled = 0

    @jax.jit
    def program(x: jax.Array) -> jax.Array:
        nonlocal compiled
        compiled += 1
        return jnp.sin(x)

    assert not forget_many_programs()
    program(jnp.ones(7))
    process(100 + grown[0], 2**30 + grown[1])
    assert not forget_many_programs()
    program(jnp.ones(7))
    assert compiled == 1
    process(101 + grown[0], 2**30 + grown[1] + 2**20)
    assert forget_many_programs()
    program(jnp.ones(7))
    assert compiled == 2
    # What is left belongs to something else: it is not dropped again and again for that.
    assert not forget_many_programs()
    process(102 + 2 * grown[0], 2**30 + 2 * grown[1] + 2**22)
    assert forget_many_programs()


def test_nothing_is_forgotten_where_the_system_does_not_tell(
    process: Process, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    assert not forget_many_programs()
    process(10 * MOST_AREAS, 2**40)
    monkeypatch.setattr(programs, "_MOST_AREAS", tmp_path / "nowhere")
    assert not forget_many_programs()
    monkeypatch.setattr(programs, "_MOST_AREAS", tmp_path / "most")
    assert forget_many_programs()


def test_every_train_makes_room(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []
    for place in ("celltrain.steady.solve", "celltrain.stability.analysis"):
        module = importlib.import_module(place)
        monkeypatch.setattr(module, "forget_many_programs", lambda: calls.append(1))
    base = steady(Train(diameter=6, packing=0.2, degree=6, cells=1), estimate_error=False)
    assert len(calls) == 1
    stability(base, azimuthal_numbers=[0], estimate_error=False)
    assert len(calls) == 2
