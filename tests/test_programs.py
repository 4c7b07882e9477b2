"""A process that goes from train to train does not keep all of its compiled programs."""

import importlib
from pathlib import Path

import jax
import jax.numpy as jnp
import pytest

from celltrain import Train, programs, stability, steady
from celltrain.programs import forget_many_programs

pytestmark = pytest.mark.skipif(
    not Path("/proc/self/maps").exists(), reason="the system does not tell what a process takes"
)


def areas() -> int:
    return len(Path("/proc/self/maps").read_text().splitlines())


@pytest.fixture
def most_areas(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Holds how many memory areas the system is said to allow."""
    path = tmp_path / "most"
    monkeypatch.setattr(programs, "_MOST_AREAS", path)
    monkeypatch.setattr(programs, "LEAST_MEMORY", 2**50)
    path.write_text("1000000000")
    return path


def test_programs_are_forgotten_when_areas_run_out(most_areas: Path) -> None:
    compiled = [jax.jit(lambda x, n=n: jnp.sin(x) * n) for n in range(60)]
    assert not forget_many_programs()
    before = areas()
    for each in compiled:
        each(jnp.ones(7))
    grown = areas()
    # What is the reason for all this: each program takes areas.
    assert grown > before + 60
    assert not forget_many_programs()
    most_areas.write_text(str(2 * grown - 2))
    assert forget_many_programs()
    assert areas() < grown - 60
    assert not forget_many_programs()


def test_programs_are_forgotten_when_memory_runs_out(
    most_areas: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(programs, "LEAST_MEMORY", 2**20)
    monkeypatch.setattr("os.cpu_count", lambda: 2**20)
    assert forget_many_programs()


def test_every_train_makes_room(most_areas: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []
    for place in ("celltrain.steady.solve", "celltrain.stability.analysis"):
        module = importlib.import_module(place)
        monkeypatch.setattr(module, "forget_many_programs", lambda: calls.append(1))
    base = steady(Train(diameter=6, packing=0.2, degree=6, cells=1), estimate_error=False)
    assert len(calls) == 1
    stability(base, azimuthal_numbers=[0], estimate_error=False)
    assert len(calls) == 2
