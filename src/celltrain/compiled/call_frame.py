"""How XLA calls a compiled loop, and where the loop finds its arguments.

XLA calls a C function with one argument, the address of a frame of 64-bit words, as described by
`XLA_FFI_CallFrame` in the header xla/ffi/api/c_api.h that comes with jaxlib (version 0.3 of that
interface, or 0.4, which takes what was written for 0.3 and has another name for one structure).
Before the first call it asks for the version that the function was written for. Such a function is

    @handler("name")
    def handle(frame_address):
        if not answered(frame_address):
            values, found = numbers(frame_address, 0), result(frame_address)
            ...
        return 0

for which `shared_work` has one that lets several threads run a loop. Arrays are handed over flat,
in C order; it must not raise. Numba keeps the machine code beside the source files, or in its cache
folder where these cannot be written, and looks for changes in the function's own file only: after
one in another file (of this folder, or `parts`) remove what it has kept.

All numbers below are compared with the header when this module is imported. Where they differ from
it, or the machine is not one of 64 bits with the lowest byte first, XLA calls no loop.
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
from llvmlite import ir
from numba import carray, cfunc, types
from numba.extending import intrinsic

import celltrain.runtime  # noqa: F401
from celltrain.compiled.header import HEADER, Header
from celltrain.parts import part

#: Address of the frame -> address of an error, 0 for none.
Loop: TypeAlias = Callable[[int], int]
_SIGNATURE = types.int64(types.int64)

# Types of arguments.
FLOATS, INTEGERS, FLAGS = np.dtype(np.float64), np.dtype(np.int64), np.dtype(np.bool_)

# Words of the frame: what extends it, and the lists of the arguments' and results' addresses.
_EXTENSION, ARGUMENTS, RESULTS = 1, 9, 14
# Words of the frame again: the functions that XLA offers, and what they are told who calls; among
# those functions, what lets a thread run a task, and how many threads there are.
API, CONTEXT, SCHEDULE, NUMBER_OF_THREADS = 2, 3, 17, 18
# Words of a buffer: address of its data, number of its axes, address of their sizes.
DATA, RANK, SIZES = 3, 4, 5
# Words of what extends a frame: its kind (half a word), of which one is the question for the
# version, and the address of the answer; words of the answer.
_KIND, _QUESTION, _ANSWER = 1, 1, 3
_VERSION, _TRAITS = 3, 4
_MAJOR, _MINOR = 0, 3
# Versions that take what was written for the first, and their names of what extends a frame.
_MINORS = {3: "XLA_FFI_Extension_Base", 4: "XLA_FFI_InternalExtension"}

# What stands above, by the header's names; of what XLA's functions are given, words that
# `shared_work` fills.
_BY_NAME = {
    "XLA_FFI_API_MAJOR": _MAJOR,
    "XLA_FFI_Extension_Metadata": _QUESTION,
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
    ("XLA_FFI_CallFrame", "args.args"): ARGUMENTS,
    ("XLA_FFI_CallFrame", "rets.rets"): RESULTS,
    ("XLA_FFI_Buffer", "data"): DATA,
    ("XLA_FFI_Buffer", "rank"): RANK,
    ("XLA_FFI_Buffer", "dims"): SIZES,
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
#: Whether programs call loops, on processors.
LOOPS_SERVE = _REASON is None
if not LOOPS_SERVE:
    warnings.warn(
        "celltrain uses plain formulas in place of its compiled loops, which makes velocities"
        f" several times slower: {_REASON}",
        RuntimeWarning,
        stacklevel=2,
    )


@intrinsic
def word(typing_context: Any, address: Any) -> Any:
    """The 64-bit word at an address."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.load(builder.inttoptr(arguments[0], ir.IntType(64).as_pointer()))

    return types.int64(types.int64), generate


@intrinsic
def set_word(typing_context: Any, address: Any, value: Any) -> Any:
    """Write the 64-bit word at an address."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        builder.store(arguments[1], builder.inttoptr(arguments[0], ir.IntType(64).as_pointer()))
        return context.get_dummy_value()

    return types.void(types.int64, types.int64), generate


@intrinsic
def _pointer(typing_context: Any, address: Any) -> Any:
    """The address as a pointer."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], context.get_value_type(types.voidptr))

    return types.voidptr(types.int64), generate


@part()
def answered(frame: int) -> bool:
    """Whether a frame asks for the version of the interface only, and has got it."""
    extension = word(frame + 8 * _EXTENSION)
    if extension == 0 or word(extension + 8 * _KIND) & 0xFFFFFFFF != _QUESTION:
        return False
    answer = word(extension + 8 * _ANSWER)
    set_word(answer + 8 * _VERSION, _MAJOR | (_MINOR << 32))
    set_word(answer + 8 * _TRAITS, 0)
    return True


# Numba compiles a function anew for each constant it is called with, unless the call is replaced by
# the function's lines; addresses are no constants.
@part(inline="always")
def _argument(frame: int, number: int) -> int:
    return word(word(frame + 8 * ARGUMENTS) + 8 * number)


@part()
def _sizes(buffer: int) -> np.ndarray:
    return carray(_pointer(word(buffer + 8 * SIZES)), (word(buffer + 8 * RANK),), np.int64)


@part()
def _count(buffer: int) -> int:
    count = 1
    for axis in range(word(buffer + 8 * RANK)):
        count *= word(word(buffer + 8 * SIZES) + 8 * axis)
    return count


@part()
def _numbers(buffer: int) -> np.ndarray:
    return carray(_pointer(word(buffer + 8 * DATA)), (_count(buffer),), np.float64)


@part()
def _integers(buffer: int) -> np.ndarray:
    return carray(_pointer(word(buffer + 8 * DATA)), (_count(buffer),), np.int64)


@part()
def _flags(buffer: int) -> np.ndarray:
    return carray(_pointer(word(buffer + 8 * DATA)), (_count(buffer),), np.uint8)


@part(inline="always")
def sizes(frame: int, number: int) -> np.ndarray:
    """Sizes of the axes of an argument."""
    return _sizes(_argument(frame, number))


@part(inline="always")
def numbers(frame: int, number: int) -> np.ndarray:
    """An argument of 64-bit floats, flat."""
    return _numbers(_argument(frame, number))


@part(inline="always")
def integers(frame: int, number: int) -> np.ndarray:
    """An argument of 64-bit integers, flat."""
    return _integers(_argument(frame, number))


@part(inline="always")
def flags(frame: int, number: int) -> np.ndarray:
    """An argument of truth values, flat, as bytes."""
    return _flags(_argument(frame, number))


@part(inline="always")
def result(frame: int) -> np.ndarray:
    """The result, 64-bit floats, flat."""
    return _numbers(word(word(frame + 8 * RESULTS)))


@part(inline="always")
def result_sizes(frame: int) -> np.ndarray:
    """Sizes of the axes of the result."""
    return _sizes(word(word(frame + 8 * RESULTS)))


def handler(name: str) -> Callable[[Loop], Any]:
    """Compile what XLA calls by a name, on processors, and let it find that."""

    def compiled(function: Loop) -> Any:
        made = c_function(function)
        make_capsule = ctypes.pythonapi.PyCapsule_New
        make_capsule.restype = ctypes.py_object
        make_capsule.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p]
        jax.ffi.register_ffi_target(name, make_capsule(made.address, None, None), platform="cpu")
        return made

    return compiled


def c_function(function: Loop) -> Any:
    """A function compiled for callers of its address; its machine code is kept if it can be."""
    # Divisions by zero give infinity, as those in `parts` do.
    options = {"error_model": "numpy"}
    try:
        return cfunc(_SIGNATURE, cache=True, **options)(function)
    except RuntimeError:
        # Nowhere to keep the machine code: it is made anew in every process.
        return cfunc(_SIGNATURE, **options)(function)
