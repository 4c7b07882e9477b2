"""A simulation's loops, compiled by another process while this one computes something else.

    python -m celltrain.compiled.ahead NAME ...

Numba keeps what it has made, so that this process then finds it; it compiles by itself what it
wants before that.
"""

import atexit
import os
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

from celltrain.compiled.block_loops import (
    CLOSE_TYPES,
    FACING_TYPES,
    close_on_host,
    facing_on_host,
)
from celltrain.compiled.call_frame import LOOPS_SERVE
from celltrain.compiled.loops import (
    CLOSE_FORCES,
    MODULES,
    NEAREST,
    OWN_DOUBLE_LAYER,
    STRESSLET_PAIRS,
    make,
)
from celltrain.compiled.nearest_search import NEAREST_TYPES, nearest_on_host
from celltrain.compiled.shared_work import help_with

# Functions that Python calls, which are wanted after the loops.
_ON_HOST: dict[str, tuple[Any, tuple[Any, ...]]] = {
    function.__name__: (function, types)
    for function, types in (
        (facing_on_host, FACING_TYPES),
        (nearest_on_host, NEAREST_TYPES),
        (close_on_host, CLOSE_TYPES),
    )
}
# What a simulation wants last: this process begins with the rest.
_LAST = (NEAREST, CLOSE_FORCES, *_ON_HOST)
_VISCOUS = (OWN_DOUBLE_LAYER, STRESSLET_PAIRS)

_begun = threading.Event()


def compile_ahead(viscosity_ratio: float) -> None:
    """Begin to compile what a simulation wants and Numba has not kept, once in a process.

    Nothing is done where it would be of no use, or no other process can be had.
    """
    # A frozen application would begin itself.
    python = None if getattr(sys, "frozen", False) else sys.executable
    if not LOOPS_SERVE or not python or _processors() < 2 or _begun.is_set():
        return
    names = _missing((*(_VISCOUS if viscosity_ratio != 1.0 else ()), *_LAST))
    if not names:
        return
    _begun.set()
    quiet = subprocess.DEVNULL
    # Not from the user's folder (-P), whatever lies there.
    command = [python, "-P", "-m", __spec__.name, *names]
    with suppress(OSError):
        child = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=quiet, stderr=quiet)
        threading.Thread(target=child.wait, daemon=True).start()
        atexit.register(_end, child)


def _processors() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _missing(names: tuple[str, ...]) -> list[str]:
    """Those of which Numba has kept nothing; none of them where it can keep nothing."""
    kept = getattr(help_with, "_cache", None)
    folder = getattr(kept, "cache_path", None)
    if folder is None:
        return []
    return [name for name in names if not any(Path(folder).glob(f"{_file(name)}-*.nbi"))]


def _file(name: str) -> str:
    """Beginning of the names of the files in which Numba keeps something."""
    if name in _ON_HOST:
        function = _ON_HOST[name][0].py_func
        return f"{function.__module__.rpartition('.')[2]}.{name}"
    return f"{MODULES[name]}.*_handler"


def _end(child: subprocess.Popen[bytes]) -> None:
    child.kill()
    child.wait()


def _compile(name: str) -> None:
    if name in _ON_HOST:
        function, types = _ON_HOST[name]
        function.compile(types)
    elif name in MODULES:
        make(name)
    else:
        raise ValueError(f"{name} is none of {', '.join((*MODULES, *_ON_HOST))}")


def _end_with(pipe: int, end: Callable[[], object]) -> None:
    """Wait for the end of a pipe, which nobody writes to: of who has begun this process."""
    # Not by a file object: its lock would be held when the interpreter ends.
    with suppress(OSError):
        os.read(pipe, 1)
    end()


if __name__ == "__main__":
    watch = (sys.stdin.fileno(), partial(os._exit, 1))
    threading.Thread(target=_end_with, args=watch, daemon=True).start()
    for each in sys.argv[1:]:
        _compile(each)
