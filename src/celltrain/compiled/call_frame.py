"""How XLA calls a compiled loop, and where the loop finds its arguments.

XLA calls a C function with one argument, the address of a frame of 64-bit words, as described by
`XLA_FFI_CallFrame` in the header xla/ffi/api/c_api.h that comes with jaxlib (version 0.3 of that
interface). Before the first call it asks for the version that the function was written for. A loop
is

    @handler("name")
    def loop(frame_address):
        if is_question(frame_address):
            return describe(frame_address)
        values = numbers(frame_address, 0)
        result(frame_address)[:] = ...
        return 0

which `jax.ffi.ffi_call("name", ...)` calls. Arrays are handed over flat, in C order; a loop must
not raise. Numba keeps the machine code beside the source files, or in its cache folder where these
cannot be written; after a change in this module remove it.
"""

import ctypes
from collections.abc import Callable
from typing import Any

import jax
import numpy as np
from numba import carray, cfunc, njit, types
from numba.extending import intrinsic

import celltrain.runtime  # noqa: F401

# Address of the frame -> address of an error, 0 for none.
_SIGNATURE = types.int64(types.int64)

# Words of the frame: what extends it, and the lists of the arguments' and results' addresses.
_EXTENSION, _ARGUMENTS, _RESULTS, _FRAME_WORDS = 1, 9, 14, 22
# Words of a buffer: address of its data, number of its axes, address of their sizes.
_DATA, _RANK, _SIZES, _BUFFER_WORDS = 3, 4, 5, 6
# Words of what extends a frame: its kind (half a word), of which one is the question for the
# version, and the address of the answer; words of the answer.
_KIND, _QUESTION, _ANSWER = 1, 1, 3
_VERSION, _TRAITS, _ANSWER_WORDS = 3, 4, 5
_MAJOR, _MINOR = 0, 3


@intrinsic
def _pointer(typing_context: Any, address: Any) -> Any:
    """The address as a pointer."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], context.get_value_type(types.voidptr))

    return types.voidptr(types.int64), generate


@njit(inline="always")
def _words(address: int, count: int) -> Any:
    return carray(_pointer(address), (count,), np.int64)


@njit(inline="always")
def is_question(frame: int) -> Any:
    """Whether XLA asks for the version of the interface instead of a result."""
    extension = _words(frame, _FRAME_WORDS)[_EXTENSION]
    return extension != 0 and _words(extension, _KIND + 1)[_KIND] & 0xFFFFFFFF == _QUESTION


@njit(inline="always")
def describe(frame: int) -> int:
    """Answer that question."""
    extension = _words(_words(frame, _FRAME_WORDS)[_EXTENSION], _ANSWER + 1)
    answer = _words(extension[_ANSWER], _ANSWER_WORDS)
    answer[_VERSION] = _MAJOR | (_MINOR << 32)
    answer[_TRAITS] = 0
    return 0


@njit(inline="always")
def _buffer(frame: int, place: int, number: int) -> Any:
    listed = _words(_words(frame, _FRAME_WORDS)[place], number + 1)
    return _words(listed[number], _BUFFER_WORDS)


@njit(inline="always")
def sizes(frame: int, number: int) -> Any:
    """Sizes of the axes of an argument."""
    buffer = _buffer(frame, _ARGUMENTS, number)
    return _words(buffer[_SIZES], buffer[_RANK])


@njit(inline="always")
def _count(buffer: Any) -> int:
    count = 1
    for size in _words(buffer[_SIZES], buffer[_RANK]):
        count *= size
    return count


@njit(inline="always")
def numbers(frame: int, number: int) -> Any:
    """An argument of 64-bit floats, flat."""
    buffer = _buffer(frame, _ARGUMENTS, number)
    return carray(_pointer(buffer[_DATA]), (_count(buffer),), np.float64)


@njit(inline="always")
def integers(frame: int, number: int) -> Any:
    """An argument of 64-bit integers, flat."""
    buffer = _buffer(frame, _ARGUMENTS, number)
    return carray(_pointer(buffer[_DATA]), (_count(buffer),), np.int64)


@njit(inline="always")
def flags(frame: int, number: int) -> Any:
    """An argument of truth values, flat, as bytes."""
    buffer = _buffer(frame, _ARGUMENTS, number)
    return carray(_pointer(buffer[_DATA]), (_count(buffer),), np.uint8)


@njit(inline="always")
def result(frame: int) -> Any:
    """The result, 64-bit floats, flat."""
    buffer = _buffer(frame, _RESULTS, 0)
    return carray(_pointer(buffer[_DATA]), (_count(buffer),), np.float64)


def handler(name: str) -> Callable[[Callable[[int], int]], Any]:
    """Compile a loop, and let `jax.ffi.ffi_call(name, ...)` call it, on processors."""

    def compiled(loop: Callable[[int], int]) -> Any:
        try:
            made = cfunc(_SIGNATURE, cache=True)(loop)
        except RuntimeError:
            # Nowhere to keep the machine code: it is made anew in every process.
            made = cfunc(_SIGNATURE)(loop)
        make_capsule = ctypes.pythonapi.PyCapsule_New
        make_capsule.restype = ctypes.py_object
        make_capsule.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p]
        jax.ffi.register_ffi_target(name, make_capsule(made.address, None, None), platform="cpu")
        return made

    return compiled
