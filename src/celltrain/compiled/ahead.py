"""A simulation's loops, compiled by another process while this one computes something else.

    python -m celltrain.compiled.ahead NAME ...

Numba keeps what it has made, so that this process then finds it; it compiles by itself what it
wants before that.
"""

import os
import subprocess
import sys

from celltrain.compiled.block_loops import (
    CLOSE_TYPES,
    FACING_TYPES,
    close_on_host,
    facing_on_host,
)
from celltrain.compiled.call_frame import LOOPS_SERVE
from celltrain.compiled.loops import (
    CLOSE_FORCES,
    NEAREST,
    OWN_DOUBLE_LAYER,
    STRESSLET_PAIRS,
    make,
)
from celltrain.compiled.nearest_search import NEAREST_TYPES, nearest_on_host
from celltrain.compiled.shared_work import help_with

# Those that simulations want last: they begin with the others.
_CLOSE, _VISCOUS = (NEAREST, CLOSE_FORCES), (OWN_DOUBLE_LAYER, STRESSLET_PAIRS)

_begun: list[subprocess.Popen[bytes]] = []


def compile_ahead(viscosity_ratio: float) -> None:
    """Begin to compile what a simulation wants, if no loop is kept yet and a processor is free."""
    alone = hasattr(os, "sched_getaffinity") and len(os.sched_getaffinity(0)) < 2
    if not LOOPS_SERVE or alone or _begun or help_with.cache_hits > 0:
        return
    names = (*(_VISCOUS if viscosity_ratio != 1.0 else ()), *_CLOSE)
    command, quiet = [sys.executable, "-m", __spec__.name, *names], subprocess.DEVNULL
    _begun.append(subprocess.Popen(command, stdin=quiet, stdout=quiet, stderr=quiet))


if __name__ == "__main__":
    for each in sys.argv[1:]:
        make(each)
    # What is called from Python is wanted only then.
    facing_on_host.compile(FACING_TYPES)
    nearest_on_host.compile(NEAREST_TYPES)
    close_on_host.compile(CLOSE_TYPES)
