"""Compiled loops called by Python with arrays of NumPy: the same machine code as in programs."""

import ctypes
from concurrent.futures import ThreadPoolExecutor
from functools import cache

import numpy as np
from jaxtyping import Float

from celltrain.compiled.call_frame import ARGUMENTS, DATA, RANK, RESULTS, SIZES
from celltrain.compiled.loops import CompiledLoop
from celltrain.compiled.shared_work import FRAME, MOST_THREADS, WORDS, slot
from celltrain.environment import processors

_TASK = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64)


class _Buffer:
    """An array as loops find it, kept as long as this is."""

    def __init__(self, array: np.ndarray) -> None:
        self._array = np.asarray(array, order="C")
        self._sizes = np.array(array.shape, dtype=np.int64)
        self._words = np.zeros(SIZES + 1, dtype=np.int64)
        self._words[DATA] = self._array.ctypes.data
        self._words[RANK], self._words[SIZES] = array.ndim, self._sizes.ctypes.data

    @property
    def address(self) -> int:
        """Address of its words."""
        return int(self._words.ctypes.data)


def call_on_host(
    compiled: CompiledLoop, shape: tuple[int, ...], *arguments: np.ndarray
) -> Float[np.ndarray, "..."]:
    """Result of a loop, an array of the given shape; other threads share its work.

    **Raises:** `TypeError` for arguments of other types than the loop's; `RuntimeError` if the loop
    fails, which says why on standard error.
    """
    compiled.check(arguments)
    compiled.make()
    found = np.empty(shape)
    buffers = [_Buffer(each) for each in (*arguments, found)]
    addresses = np.array([each.address for each in buffers])
    frame, work = np.zeros(RESULTS + 1, dtype=np.int64), np.zeros(WORDS, dtype=np.int64)
    frame[ARGUMENTS], frame[RESULTS] = addresses.ctypes.data, addresses[-1:].ctypes.data
    work[FRAME] = frame.ctypes.data
    run = _TASK(slot(compiled.name).value)

    def take_part(*_: object) -> bool:
        # Python lets go of its lock meanwhile.
        return bool(run(work.ctypes.data) == 1)

    # With what is used, which must live as long as a thread uses it.
    helpers = [
        _threads().submit(take_part, frame, addresses, buffers)
        for _ in range(min(processors(), MOST_THREADS) - 1)
    ]
    done = [take_part()]
    # Those that have not begun would find nothing left.
    done += [each.result() for each in helpers if not each.cancel()]
    if not all(done):
        raise RuntimeError(f"{compiled.name} failed")
    return found


@cache
def _threads() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(processors())
