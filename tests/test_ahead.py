"""Loops that another process compiles: which, when, and that they are those that are wanted."""

import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from test_repulsion import placed, sphere

from celltrain.compiled import ahead
from celltrain.compiled.block_loops import (
    CLOSE_TYPES,
    FACING_TYPES,
    close_on_host,
    facing_on_host,
)
from celltrain.compiled.loops import CLOSE_FORCES, NEAREST, OWN_DOUBLE_LAYER, STRESSLET_PAIRS
from celltrain.compiled.nearest_search import NEAREST_TYPES, nearest_on_host
from celltrain.proximity.film_points import film_grid

DEGREE = 6


@pytest.fixture
def begun(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """Commands of the processes that are begun."""
    commands: list[list[str]] = []
    monkeypatch.setattr(ahead, "_begun", [])
    monkeypatch.setattr(ahead.os, "sched_getaffinity", lambda _: {0, 1}, raising=False)
    monkeypatch.setattr(
        ahead.subprocess, "Popen", lambda command, **_: commands.append(list(command))
    )
    return commands


@pytest.mark.parametrize(
    ("ratio", "names"),
    [
        (1.0, [NEAREST, CLOSE_FORCES]),
        (5.0, [OWN_DOUBLE_LAYER, STRESSLET_PAIRS, NEAREST, CLOSE_FORCES]),
    ],
)
def test_what_a_simulation_wants_is_begun_once(
    begun: list[list[str]], monkeypatch: pytest.MonkeyPatch, ratio: float, names: list[str]
) -> None:
    monkeypatch.setattr(ahead, "help_with", SimpleNamespace(cache_hits=0))
    ahead.compile_ahead(ratio)
    ahead.compile_ahead(ratio)
    assert begun == [[sys.executable, "-m", "celltrain.compiled.ahead", *names]]


def test_nothing_is_begun_where_loops_are_kept_or_no_processor_is_free(
    begun: list[list[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ahead, "help_with", SimpleNamespace(cache_hits=1))
    ahead.compile_ahead(1.0)
    monkeypatch.setattr(ahead, "help_with", SimpleNamespace(cache_hits=0))
    monkeypatch.setattr(ahead.os, "sched_getaffinity", lambda _: {0})
    ahead.compile_ahead(1.0)
    assert begun == []


def test_the_process_compiles_what_it_is_told() -> None:
    subprocess.run([sys.executable, "-m", ahead.__name__, NEAREST], check=True)


def test_types_are_those_that_a_search_for_films_has() -> None:
    """Others would be compiled, and what is wanted again."""
    grid, shape = film_grid(DEGREE), sphere(DEGREE)
    shapes = placed(shape, (0.0, 0.0, 0.0), (0.0, 0.0, 2.01))
    found = grid.find(shapes, grid.coarse.surfaces(shapes), within=0.05, period=20.0)
    assert len(found.cell) > 0
    for function, types in (
        (facing_on_host, FACING_TYPES),
        (close_on_host, CLOSE_TYPES),
        (nearest_on_host, NEAREST_TYPES),
    ):
        assert types in function.signatures
        assert len(function.signatures) == 1
    assert np.isfinite(found.distance).all()
