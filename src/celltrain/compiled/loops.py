"""The loops, each made when a program first wants it.

Making one takes Numba seconds, unless it has kept the machine code: no program waits for loops that
it does without.
"""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from celltrain.compiled.call_frame import FLAGS, FLOATS, INTEGERS
from celltrain.compiled.shared_work import answer, slot
from celltrain.environment import CACHE
from celltrain.programs import offer

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]


@dataclass(frozen=True)
class CompiledLoop:
    """A loop by the name under which XLA finds it.

    Attributes:
        module: the one whose import makes it.
        arguments: their types.
    """

    name: str
    module: str
    arguments: tuple[np.dtype[Any], ...]

    def check(self, arguments: Sequence[Any]) -> None:
        """Refuse arrays of other types than its arguments', with a `TypeError`."""
        given = tuple(each.dtype for each in arguments)
        if given != self.arguments:
            raise TypeError(f"{self.name} is given {given} in place of {self.arguments}")

    def declare(self) -> None:
        """Let XLA find it by its name, so that programs that call it can be compiled."""
        answer(self.name)

    def make(self) -> None:
        """Have it compiled now, unless it is kept or known already.

        One process at a time compiles it: the others then load what that one has kept.
        """
        if slot(self.name).value:
            return
        with _alone(self.module):
            import_module(self.module)


@contextmanager
def _alone(module: str) -> Iterator[None]:
    """Wait for other processes that make the same; not where there is no folder or no such lock."""
    if CACHE is None or fcntl is None:
        yield
        return
    try:
        lock = open(os.path.join(CACHE, f"{module}.lock"), "w")  # noqa: SIM115
    except OSError:
        yield
        return
    with lock:
        with suppress(OSError):
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield


_PAIRS = (FLOATS, FLOATS, FLOATS, FLAGS, INTEGERS, INTEGERS, FLAGS, FLOATS, FLOATS)
_CLOSE = (FLOATS, FLOATS, INTEGERS, FLOATS, INTEGERS, INTEGERS, *(FLOATS,) * 5)


def _loop(name: str, module: str, *arguments: np.dtype[Any]) -> CompiledLoop:
    return CompiledLoop(f"celltrain_{name}", f"celltrain.compiled.{module}", arguments)


FORCE_PAIRS = _loop("force_pairs", "force_pair_loop", *_PAIRS)
STRESSLET_PAIRS = _loop("stresslet_pairs", "stresslet_pair_loop", *_PAIRS)
OWN_FORCES = _loop("own_forces", "own_surface_loop", *(FLOATS,) * 8)
OWN_DOUBLE_LAYER = _loop("own_double_layer", "own_double_layer_loop", *(FLOATS,) * 11)
CLOSE_FORCES = _loop("close_forces", "close_loop", *_CLOSE)
SPREAD = _loop("spread", "spread_loop", *(FLOATS,) * 3)
INTERPOLATE = _loop("interpolate", "interpolate_loop", *(FLOATS,) * 3)
NEAREST = _loop("nearest", "nearest_loop", FLOATS, INTEGERS, FLOATS, FLOATS, FLAGS)
FACING = _loop("facing", "facing_loop", FLOATS, FLOATS, INTEGERS, FLOATS)

#: All of them by their names; one after the other those that have much in common, which is compiled
#: once.
LOOPS = {
    each.name: each
    for each in (
        FORCE_PAIRS,
        STRESSLET_PAIRS,
        OWN_FORCES,
        OWN_DOUBLE_LAYER,
        CLOSE_FORCES,
        SPREAD,
        INTERPOLATE,
        NEAREST,
        FACING,
    )
}
for _each in LOOPS.values():
    offer(_each)
