"""How XLA calls a compiled loop, and where the loop finds its arguments.

XLA calls a C function with one argument, the address of a frame of 64-bit words, as described by
`XLA_FFI_CallFrame` in the header xla/ffi/api/c_api.h that comes with jaxlib (version 0.3 of that
interface, or 0.4, which takes what was written for 0.3 and has another name for one structure).
Before the first call it asks for the version that the function was written for. A loop is

    @handler("name")
    def loop(frame_address):
        if not answered(frame_address, (FLOATS,)):
            values = numbers(frame_address, 0)
            result(frame_address)[:] = ...
        return 0

which `dispatch.compiled_or_plain` calls. Arrays are handed over flat, in C order; a loop must not
raise. Numba keeps the machine code beside the source files, or in its cache folder where these
cannot be written; after a change in this module or in what the loops share (`kernels`,
`near_loops`, `polar_lanes`, `shared_work`) remove it.

All numbers below are compared with the header when this module is imported. Where they differ from
it, or the machine is not one of 64 bits with the lowest byte first, no loop is compiled or used.
"""

import ctypes
import sys
import warnings
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeAlias

import jax
import numpy as np
from numba import carray, cfunc, njit, types
from numba.extending import intrinsic

import celltrain.runtime  # noqa: F401
from celltrain.compiled.header import HEADER, Header

#: Address of the frame -> address of an error, 0 for none.
Loop: TypeAlias = Callable[[int], int]
_SIGNATURE = types.int64(types.int64)

# Words of the frame: what extends it, and the lists of the arguments' and results' addresses.
_EXTENSION, _ARGUMENTS, _RESULTS, _FRAME_WORDS = 1, 9, 14, 22
# Words of the frame again: the functions that XLA offers, and what they are told who calls; among
# those functions, what lets a thread run a task, and how many threads there are.
API, CONTEXT, SCHEDULE, NUMBER_OF_THREADS = 2, 3, 17, 18
# Words of a buffer: type (half a word), address of its data, number of its axes, address of their
# sizes.
_TYPE, _DATA, _RANK, _SIZES, _BUFFER_WORDS = 2, 3, 4, 5, 6
# Types of arguments: 64-bit floats, 64-bit integers, truth values.
FLOATS, INTEGERS, FLAGS = 12, 5, 1
# Words of what extends a frame: its kind (half a word), of which one is the question for the
# version, and the address of the answer; words of the answer.
_KIND, _QUESTION, _ANSWER = 1, 1, 3
_VERSION, _TRAITS, _ANSWER_WORDS = 3, 4, 5
_MAJOR, _MINOR = 0, 3
# Versions that take what was written for the first, and their names of what extends a frame.
_MINORS = {3: "XLA_FFI_Extension_Base", 4: "XLA_FFI_InternalExtension"}

# What stands above, by the header's names; of what XLA's functions are given, words that
# `shared_work` fills.
_BY_NAME = {
    "XLA_FFI_API_MAJOR": _MAJOR,
    "XLA_FFI_Extension_Metadata": _QUESTION,
    "XLA_FFI_DataType_F64": FLOATS,
    "XLA_FFI_DataType_S64": INTEGERS,
    "XLA_FFI_DataType_PRED": FLAGS,
}
_PLACES: dict[tuple[str, str], float] = {
    ("XLA_FFI_CallFrame", "extension_start"): _EXTENSION,
    ("XLA_FFI_CallFrame", "api"): API,
    ("XLA_FFI_CallFrame", "ctx"): CONTEXT,
    ("XLA_FFI_Api", "XLA_FFI_ThreadPool_Schedule"): SCHEDULE,
    ("XLA_FFI_Api", "XLA_FFI_ThreadPool_NumThreads"): NUMBER_OF_THREADS,
    ("XLA_FFI_ThreadPool_Schedule_Args", "ctx"): 2,
    ("XLA_FFI_ThreadPool_Schedule_Args", "task"): 3,
    ("XLA_FFI_ThreadPool_Schedule_Args", "data"): 4,
    ("XLA_FFI_ThreadPool_NumThreads_Args", "ctx"): 2,
    ("XLA_FFI_ThreadPool_NumThreads_Args", "num_threads"): 3,
    ("XLA_FFI_CallFrame", "args.args"): _ARGUMENTS,
    ("XLA_FFI_CallFrame", "rets.rets"): _RESULTS,
    ("XLA_FFI_Buffer", "dtype"): _TYPE,
    ("XLA_FFI_Buffer", "data"): _DATA,
    ("XLA_FFI_Buffer", "rank"): _RANK,
    ("XLA_FFI_Buffer", "dims"): _SIZES,
    ("XLA_FFI_Metadata_Extension", "metadata"): _ANSWER,
    ("XLA_FFI_Metadata", "api_version.major_version"): _VERSION,
    ("XLA_FFI_Metadata", "api_version.minor_version"): _VERSION + 0.5,
    ("XLA_FFI_Metadata", "traits"): _TRAITS,
}


def differences(include: Path) -> list[str]:
    """In what the header in a folder of jaxlib differs from what the loops are written for."""
    found = []
    try:
        header = Header((include / HEADER).read_text(encoding="utf-8"))
    except OSError as error:
        return [f"its header cannot be read: {error}"]
    for name, expected in _BY_NAME.items():
        number = header.numbers.get(name)
        if number != expected:
            found.append(f"{name} is {number} instead of {expected}")
    minor = header.numbers.get("XLA_FFI_API_MINOR")
    if minor not in _MINORS:
        allowed = " or ".join(map(str, _MINORS))
        found.append(f"XLA_FFI_API_MINOR is {minor} instead of {allowed}")
    extension = _MINORS.get(minor or 0, _MINORS[_MINOR])
    for (structure, field), words in (_PLACES | {(extension, "type"): _KIND}).items():
        try:
            place = header.offset(structure, field)
        except LookupError as error:
            found.append(str(error))
        else:
            if place != 8 * words:
                found.append(f"{structure}.{field} is at byte {place} instead of {8 * words:g}")
    return found


def _obstacle() -> str | None:
    """Why compiled loops cannot be used here, or None."""
    if sys.maxsize < 2**32 or sys.byteorder != "little":
        return "this machine is not one of 64 bits with the lowest byte first"
    found = differences(Path(jax.ffi.include_dir()))
    if found:
        return f"jaxlib {version('jaxlib')} calls them differently: " + "; ".join(found)
    return None


_REASON = _obstacle()
#: Whether loops are compiled and used, on processors.
LOOPS_SERVE = _REASON is None
if not LOOPS_SERVE:
    warnings.warn(
        "celltrain uses plain formulas in place of its compiled loops, which makes velocities"
        f" several times slower: {_REASON}",
        RuntimeWarning,
        stacklevel=2,
    )


@intrinsic
def _pointer(typing_context: Any, address: Any) -> Any:
    """The address as a pointer."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], context.get_value_type(types.voidptr))

    return types.voidptr(types.int64), generate


@njit
def words(address: int, count: int) -> np.ndarray:
    """So many 64-bit words from an address on."""
    return carray(_pointer(address), (count,), np.int64)


@njit
def answered(frame: int, kinds: tuple[int, ...]) -> bool:
    """Whether a frame wants nothing computed, and has got what it wants.

    It asks for the version of the interface, or its arguments are not of these types: then its
    result becomes NaN.
    """
    if _is_question(frame):
        _describe(frame)
        return True
    if not _fits(frame, kinds):
        result(frame)[:] = np.nan
        return True
    return False


@njit
def _is_question(frame: int) -> bool:
    extension = words(frame, _FRAME_WORDS)[_EXTENSION]
    return extension != 0 and words(extension, _KIND + 1)[_KIND] & 0xFFFFFFFF == _QUESTION


@njit
def _describe(frame: int) -> None:
    extension = words(words(frame, _FRAME_WORDS)[_EXTENSION], _ANSWER + 1)
    answer = words(extension[_ANSWER], _ANSWER_WORDS)
    answer[_VERSION] = _MAJOR | (_MINOR << 32)
    answer[_TRAITS] = 0


@njit
def _buffer(frame: int, place: int, number: int) -> np.ndarray:
    listed = words(words(frame, _FRAME_WORDS)[place], number + 1)
    return words(listed[number], _BUFFER_WORDS)


@njit
def _fits(frame: int, kinds: tuple[int, ...]) -> bool:
    for number in range(len(kinds)):
        if _buffer(frame, _ARGUMENTS, number)[_TYPE] & 0xFFFFFFFF != kinds[number]:
            return False
    return True


@njit
def sizes(frame: int, number: int) -> np.ndarray:
    """Sizes of the axes of an argument."""
    buffer = _buffer(frame, _ARGUMENTS, number)
    return words(buffer[_SIZES], buffer[_RANK])


@njit
def _count(buffer: np.ndarray) -> int:
    count = 1
    for size in words(buffer[_SIZES], buffer[_RANK]):
        count *= size
    return count


@njit
def numbers(frame: int, number: int) -> np.ndarray:
    """An argument of 64-bit floats, flat."""
    buffer = _buffer(frame, _ARGUMENTS, number)
    return carray(_pointer(buffer[_DATA]), (_count(buffer),), np.float64)


@njit
def integers(frame: int, number: int) -> np.ndarray:
    """An argument of 64-bit integers, flat."""
    buffer = _buffer(frame, _ARGUMENTS, number)
    return carray(_pointer(buffer[_DATA]), (_count(buffer),), np.int64)


@njit
def flags(frame: int, number: int) -> np.ndarray:
    """An argument of truth values, flat, as bytes."""
    buffer = _buffer(frame, _ARGUMENTS, number)
    return carray(_pointer(buffer[_DATA]), (_count(buffer),), np.uint8)


@njit
def result(frame: int) -> np.ndarray:
    """The result, 64-bit floats, flat."""
    buffer = _buffer(frame, _RESULTS, 0)
    return carray(_pointer(buffer[_DATA]), (_count(buffer),), np.float64)


def handler(name: str) -> Callable[[Loop], Loop]:
    """Compile a loop, and let XLA find it by its name, on processors, if loops serve here."""

    def compiled(loop: Loop) -> Loop:
        if not LOOPS_SERVE:
            return loop
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
