"""Parts of a loop's work, computed by whichever of XLA's threads takes them."""

import os
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from celltrain import programs
from celltrain.compiled import loop
from celltrain.compiled.call_frame import (
    FLOATS,
    answered,
    handler,
    numbers,
    result,
)
from celltrain.compiled.loops import CompiledLoop
from celltrain.compiled.on_host import call_on_host
from celltrain.compiled.shared_work import (
    frame_of,
    help_with,
    next_part,
    share,
    slot,
    slot_of,
    task,
)

# Where the loops stand: compiled by the first test that wants one.
LOOPS = "shared_loops"
PARTS = 97


@dataclass(frozen=True)
class LoopIntoZeros(CompiledLoop):
    """A loop that adds to its result, which is zero when it begins."""

    def declare(self) -> None:
        name = self.name
        slot(name)

        @handler(name)
        def handle(frame: int) -> int:
            if not answered(frame):
                result(frame)[:] = 0.0
            return share(frame, slot_of(name))


COUNTING = LoopIntoZeros("celltrain_test_counting", LOOPS, (FLOATS,))
SEEING = LoopIntoZeros("celltrain_test_seeing", LOOPS, (FLOATS,))
DIVIDING = CompiledLoop("celltrain_test_dividing", LOOPS, (FLOATS,))


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
    from shared_loops import CLOSED, COMPUTING, FRAME, HOLDERS, LOOP, WORDS, mark

    frame, work = np.zeros(1, dtype=int), np.zeros(WORDS, dtype=int)
    work[[FRAME, LOOP, CLOSED, HOLDERS]] = frame.ctypes.data, mark.address, closed, 3
    help_with.ctypes(work.ctypes.data)
    assert frame[0] == (not closed)
    assert (work[COMPUTING], work[HOLDERS]) == (0, 2)


def test_division_by_zero_gives_infinity() -> None:
    """As in what loops call: Python's error would leave the result as it was."""
    found = jax.jit(lambda given: loop(DIVIDING, (1,), given))(jnp.zeros(1))
    np.testing.assert_array_equal(found, [np.inf])


def test_called_by_python() -> None:
    """As in a program, whatever the array's order in memory."""
    given = 1.0 + np.arange(500.0).reshape(100, 5).T
    np.testing.assert_array_equal(call_on_host(DIVIDING, given.shape, given), 1.0 / given)
    with pytest.raises(TypeError, match=f"{DIVIDING.name} is given .*int64"):
        call_on_host(DIVIDING, (1,), np.arange(3))


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_loop_that_fails_gives_no_numbers() -> None:
    failing = CompiledLoop("celltrain_test_failing", LOOPS, (FLOATS,))
    values = np.array([1.0, 2.0])
    program = jax.jit(lambda given: loop(failing, (2,), given))
    np.testing.assert_array_equal(program(values), values)
    np.testing.assert_array_equal(program(-values), [np.nan, np.nan])
    np.testing.assert_array_equal(call_on_host(failing, (2,), values), values)
    with pytest.raises(RuntimeError, match="celltrain_test_failing failed"):
        call_on_host(failing, (2,), -values)


def test_a_program_waits_for_a_loop_that_is_made_only_then() -> None:
    """It is compiled before: what XLA calls looks for the loop when it is called."""
    name = "celltrain_test_late"
    late = CompiledLoop(name, __name__, (FLOATS,))
    given = jnp.arange(1.0, 4.0)
    with programs._called():
        compiled = jax.jit(lambda values: loop(late, (3,), values)).lower(given).compile()
        # The end of this would have it made, from a module that has no task of that name.
    with ThreadPoolExecutor(1) as pool:
        found = pool.submit(lambda: np.asarray(compiled(given)))
        time.sleep(0.3)
        assert not found.done()

        @task(name)
        def double(work: int) -> int:
            if next_part(work) == 0:
                result(frame_of(work))[:] = 2.0 * numbers(frame_of(work), 0)
            return 1

        np.testing.assert_array_equal(found.result(timeout=60.0), [2.0, 4.0, 6.0])


def test_many_threads_declare_a_loop_at_once() -> None:
    """XLA takes one handler of a name."""
    for number in range(3):
        each = CompiledLoop(f"celltrain_test_together_{number}", __name__, (FLOATS,))
        begin = threading.Barrier(4)

        def declare(each: CompiledLoop = each, begin: threading.Barrier = begin) -> object:
            begin.wait()
            each.declare()
            return slot(each.name)

        with ThreadPoolExecutor(4) as pool:
            slots = [done.result() for done in [pool.submit(declare) for _ in range(4)]]
        assert all(one is slots[0] for one in slots)
        # Nothing was registered twice.
        jax.jit(lambda values: values + 1.0)(jnp.ones(number + 1))


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
        env=os.environ | {"NPROC": "1", "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
