"""A simulation's loops, compiled by another process while this one computes something else.

    python -m celltrain.compiled.ahead NAME ...

Numba keeps what it has made, so that this process then finds it. When this one comes to need them
it begins with the last, and compiles by itself what the other one has not begun.
"""

import atexit
import gc
import os
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path

from celltrain.compiled.call_frame import LOOPS_SERVE
from celltrain.compiled.loops import LOOPS, OWN_DOUBLE_LAYER, STRESSLET_PAIRS
from celltrain.compiled.shared_work import help_with
from celltrain.environment import processors

# What only cells of another viscosity than the plasma's want.
_VISCOUS = (OWN_DOUBLE_LAYER, STRESSLET_PAIRS)

_begun = threading.Event()


def compile_ahead(viscosity_ratio: float) -> None:
    """Begin to compile what a simulation wants and Numba has not kept, once in a process.

    Nothing is done where it would be of no use, or no other process can be had.
    """
    # A frozen application would begin itself.
    python = None if getattr(sys, "frozen", False) else sys.executable
    if not LOOPS_SERVE or not python or processors() < 2 or _begun.is_set():
        return
    left_out = () if viscosity_ratio != 1.0 else tuple(each.name for each in _VISCOUS)
    names = _missing([name for name in LOOPS if name not in left_out])
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


def _missing(names: list[str]) -> list[str]:
    """Those of which Numba has kept nothing; none of them where it can keep nothing."""
    # Of what Numba does not promise: where it is not there, nothing is compiled ahead.
    kept = getattr(help_with, "_cache", None)
    folder = getattr(kept, "cache_path", None)
    if folder is None:
        return []
    return [name for name in names if not _is_kept(LOOPS[name].module, Path(folder))]


def _is_kept(module: str, folder: Path) -> bool:
    """Whether Numba has kept something of a module since its file was changed."""
    name = module.rpartition(".")[2]
    source = Path(__file__).with_name(f"{name}.py")
    kept = folder.glob(f"{name}.*.nbi")
    with suppress(OSError):
        return any(each.stat().st_mtime >= source.stat().st_mtime for each in kept)
    return False


def _end(child: subprocess.Popen[bytes]) -> None:
    child.kill()
    child.wait()


def _end_with(pipe: int, end: Callable[[], object]) -> None:
    """Wait for the end of a pipe, which nobody writes to: of who has begun this process."""
    # Not by a file object: its lock would be held when the interpreter ends.
    with suppress(OSError):
        os.read(pipe, 1)
    end()


if __name__ == "__main__":
    watch = (sys.stdin.fileno(), partial(os._exit, 1))
    threading.Thread(target=_end_with, args=watch, daemon=True).start()
    # What Numba leaves behind is little beside what it takes to look for it.
    gc.disable()
    for each in sys.argv[1:]:
        if each not in LOOPS:
            raise ValueError(f"{each} is none of {', '.join(LOOPS)}")
        LOOPS[each].make()
