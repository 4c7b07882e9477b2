"""The loops by their names; each is made when a program first wants it.

Making one takes Numba seconds, unless it has kept the machine code: no program waits for loops that
it does without.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import partial
from importlib import import_module

from celltrain.environment import CACHE
from celltrain.programs import offer

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

# Names under which XLA finds the loops.
FORCE_PAIRS = "celltrain_force_pairs"
STRESSLET_PAIRS = "celltrain_stresslet_pairs"
OWN_FORCES = "celltrain_own_forces"
OWN_DOUBLE_LAYER = "celltrain_own_double_layer"
CLOSE_FORCES = "celltrain_close_forces"
NEAREST = "celltrain_nearest"

#: The module of each.
MODULES = {
    FORCE_PAIRS: "force_pair_loop",
    STRESSLET_PAIRS: "stresslet_pair_loop",
    OWN_FORCES: "own_surface_loop",
    OWN_DOUBLE_LAYER: "own_double_layer_loop",
    CLOSE_FORCES: "close_loop",
    NEAREST: "nearest_loop",
}


def make(name: str) -> None:
    """Let XLA find a loop, which is compiled now unless it is kept; others are known already.

    One process at a time compiles it: the machine code depends in its rounding on what was compiled
    before it, and all are to have the code that is kept.
    """
    if name in MODULES:
        with _alone(MODULES[name]):
            import_module(f"celltrain.compiled.{MODULES[name]}")


@contextmanager
def _alone(name: str) -> Iterator[None]:
    """Wait for other processes that make the same; not where there is no folder or no such lock."""
    if CACHE is None or fcntl is None:
        yield
        return
    try:
        lock = open(os.path.join(CACHE, f"{name}.lock"), "w")  # noqa: SIM115
    except OSError:
        yield
        return
    with lock:
        with suppress(OSError):
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield


for _name in MODULES:
    offer(_name, partial(make, _name))
