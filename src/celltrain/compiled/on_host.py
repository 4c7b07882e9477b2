"""Compiled loops called by Python with arrays of NumPy: the same machine code as in programs."""

import ctypes
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

import numpy as np
from jaxtyping import Float

from celltrain.compiled.call_frame import ARGUMENTS, DATA, RANK, RESULTS, SIZES
from celltrain.compiled.loops import CompiledLoop
from celltrain.compiled.shared_work import FRAME, WORDS, slot
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

    **Raises:** `TypeError` for arguments of other types than the loop's.
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

    def take_part() -> object:
        # Python lets go of its lock meanwhile. What is used lives as long as a thread uses it.
        run(work.ctypes.data)
        return frame, addresses, buffers

    helpers = [_threads().submit(take_part) for _ in range(processors() - 1)]
    take_part()
    for each in helpers:
        # Those that have not begun would find nothing left.
        if not each.cancel():
            each.result()
    return found


@cache
def _threads() -> Any:
    return ThreadPoolExecutor(processors())
