"""Parts of a loop's work, computed by whichever of XLA's threads takes them."""

import math
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numba import njit

from celltrain.compiled import loop
from celltrain.compiled.call_frame import FLOATS, answered, handler, numbers, result, words
from celltrain.compiled.shared_work import computed, next_part, shared, task, task_address

COUNTING, SEEING = "celltrain_test_counting", "celltrain_test_seeing"
PARTS = 97


#: Words of the work: who computes, whether it is closed, who holds it.
COMPUTING, CLOSED, HOLDERS = 2, 3, 4


@njit
def _count(frame: int, work: int) -> None:
    given, found = numbers(frame, 0), result(frame)
    part = next_part(work)
    while part < found.size:
        value = given[part % given.size]
        for _ in range(2000):
            value = math.cos(value)
        found[part] += 1.0 + 0.0 * value
        part = next_part(work)


@task(COUNTING)
def _counting_task(work: int) -> int:
    return computed(_count, work)


@handler(COUNTING)
def _counting_handler(frame: int) -> int:
    if not answered(frame, (FLOATS,)):
        result(frame)[:] = 0.0
    return shared(frame, (FLOATS,), task_address(COUNTING))


@njit
def _mark(frame: int, work: int) -> None:
    words(frame, 1)[0] = 1


@njit
def _computing(work: int) -> int:
    return words(work, 5)[COMPUTING]


@njit
def _see(frame: int, work: int) -> None:
    found = result(frame)
    part = next_part(work)
    while part < found.size:
        for _ in range(2000):
            now = _computing(work)
            if now > found[part]:
                found[part] = now
        part = next_part(work)


@task(SEEING)
def _seeing_task(work: int) -> int:
    return computed(_see, work)


@handler(SEEING)
def _seeing_handler(frame: int) -> int:
    if not answered(frame, (FLOATS,)):
        result(frame)[:] = 0.0
    return shared(frame, (FLOATS,), task_address(SEEING))


@jax.jit
def threads(given: jax.Array) -> jax.Array:
    """The most threads that computed at once while each part was computed."""
    return loop(SEEING, (PARTS,), given)


@jax.jit
def counted(given: jax.Array) -> jax.Array:
    """How often each part was computed."""
    return loop(COUNTING, (PARTS,), given)


def test_every_part_once() -> None:
    for number in range(200):
        np.testing.assert_array_equal(counted(jnp.arange(3.0) + number), np.ones(PARTS))


@pytest.mark.parametrize("closed", [False, True])
def test_nothing_is_computed_of_closed_work(closed: bool) -> None:
    """Nor is it looked at what the frame was; the thread lets the work go all the same."""
    frame, work = np.zeros(1, dtype=int), np.zeros(5, dtype=int)
    work[[0, CLOSED, HOLDERS]] = frame.ctypes.data, closed, 3
    computed(_mark, work.ctypes.data)
    assert frame[0] == (not closed)
    assert (work[COMPUTING], work[HOLDERS]) == (0, 2)


def test_others_take_part() -> None:
    """In some of many calls, as another thread may come late; none if there is one processor."""
    several = len(os.sched_getaffinity(0)) > 1
    end, calls, seen = time.monotonic() + 60.0, 0, False
    # On a machine that does other things as well it may come late very often.
    while not seen and (calls < 500 or (several and time.monotonic() < end)):
        seen, calls = bool((threads(jnp.arange(3.0)) > 1.0).any()), calls + 1
    assert seen == several


def test_many_callers_at_once() -> None:
    """More than there are threads: none waits for one that waits for it."""

    def call(number: int) -> np.ndarray:
        return np.array([counted(jnp.arange(3.0) + number + step) for step in range(20)])

    with ThreadPoolExecutor(8) as pool:
        for found in pool.map(call, range(8)):
            np.testing.assert_array_equal(found, np.ones((20, PARTS)))


def test_without_threads() -> None:
    program = f"""
from {__name__} import counted, np
assert (counted(np.arange(3.0)) == 1.0).all()
"""
    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd=Path(__file__).parents[1],
        env=os.environ | {"NPROC": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
