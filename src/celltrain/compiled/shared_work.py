"""Work of one compiled loop, shared with the threads that XLA keeps for its programs.

XLA calls a loop in one thread, and often has nothing to run beside it. A loop whose work is made of
independent parts lets others take parts of it,

    @task("name")
    def loop(work_address):
        frame_address = frame_of(work_address)
        ...
        return 1

where the loop computes the parts whose numbers `next_part` gives it until there are none left, and
returns 1 (an exception makes it return 0, and the result NaN). Which thread computes a part changes
nothing in it. Nobody waits for a thread to come: the caller takes parts as the others do, and when
none is left it waits for those that are being computed. Who comes only then finds the work closed.
What all share is a few words, released by the last.

XLA knows the loop by what `answer` has made for its name, which finds the address of the loop's
task only when it is called: programs can be compiled while the loops that they call are.
"""

import ctypes
import math
import threading
from collections.abc import Callable
from typing import Any, TypeAlias

import llvmlite.binding
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing import Context
from numba.extending import intrinsic

from celltrain.compiled.call_frame import (
    API,
    CONTEXT,
    NUMBER_OF_THREADS,
    SCHEDULE,
    Loop,
    answered,
    c_function,
    handler,
    result,
    set_word,
    word,
)
from celltrain.parts import part

# Types of what an intrinsic is called with and returns, and what writes its code.
IntrinsicParts: TypeAlias = tuple[types.FunctionType, Callable[..., ir.Value]]

# Words of the work: the frame, the loop's address, the next part, threads that compute, whether it
# is closed, who still holds its address, and how many failed.
FRAME, _LOOP, _NEXT, _COMPUTING, _CLOSED, _HOLDERS, _FAILED, WORDS = range(8)
# Name of what helpers run.
HELP = "celltrain_help"
# Threads to which parts are offered; more would find little to do.
MOST_THREADS = 16

_malloc = types.ExternalFunction("malloc", types.int64(types.uint64))
_free = types.ExternalFunction("free", types.void(types.int64))
_sched_yield = types.ExternalFunction("sched_yield", types.int32())


@intrinsic
def _added(typing_context: Any, address: Any, amount: Any) -> Any:
    """The word at an address, to which an amount is added; seen by all threads in one order."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        place = builder.inttoptr(arguments[0], ir.IntType(64).as_pointer())
        return builder.atomic_rmw("add", place, arguments[1], "seq_cst")

    return types.int64(types.int64, types.int64), generate


@intrinsic
def _called(typing_context: Any, function: Any, argument: Any) -> Any:
    """What a function gives for one argument, both addresses."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        word = ir.IntType(64)
        kind = ir.FunctionType(word, [word]).as_pointer()
        return builder.call(builder.inttoptr(arguments[0], kind), [arguments[1]])

    return types.int64(types.int64, types.int64), generate


@intrinsic(prefer_literal=True)
def slot_of(typing_context: Context, name: types.Type) -> IntrinsicParts:
    """Address of a task's slot, which the machine code finds when it is loaded."""
    symbol = _symbol(name.literal_value)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        word = ir.IntType(64)
        # Declared as a function: those are found wherever they lie.
        place = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(word, [word]), symbol
        )
        return builder.ptrtoint(place, word)

    return types.int64(name), generate


def _symbol(name: str) -> str:
    return f"{name}_slot"


_slots: dict[str, ctypes.c_int64] = {}
_answers: dict[str, Any] = {}
_one_at_a_time = threading.RLock()


def slot(name: str) -> ctypes.c_int64:
    """Where the address of the task of a name stands, 0 until there is one."""
    with _one_at_a_time:
        if name not in _slots:
            made = _slots[name] = ctypes.c_int64(0)
            llvmlite.binding.add_symbol(_symbol(name), ctypes.addressof(made))
        return _slots[name]


def task(name: str) -> Callable[[Loop], Any]:
    """Compile the task of a name, and write its address in its slot."""

    def compiled(function: Loop) -> Any:
        made = c_function(function)
        slot(name).value = made.address
        return made

    return compiled


def answer(name: str) -> Any:
    """Compile what XLA calls by a name: it has the task of that name shared, once there is one."""

    def handle(frame: int) -> int:
        return share(frame, slot_of(name))

    # So that Numba keeps each in a file of its own.
    handle.__qualname__ = f"answer_{name}"
    with _one_at_a_time:
        if name not in _answers:
            slot(name)
            _answers[name] = handler(name)(handle)
        return _answers[name]


@part()
def frame_of(work: int) -> int:
    """Address of the frame whose parts are computed."""
    return word(work + 8 * FRAME)


@part()
def next_part(work: int) -> int:
    """Number of a part that nobody has taken yet, counted on beyond the last."""
    return _added(work + 8 * _NEXT, 1)


@part()
def _release(work: int) -> None:
    if _added(work + 8 * _HOLDERS, -1) == 1:
        _free(work)


@task(HELP)
def help_with(work: int) -> int:
    """Run the work's task on the parts that it can get, unless the work is closed already."""
    _added(work + 8 * _COMPUTING, 1)
    # Only then: who closes the work waits for all that are counted.
    if _added(work + 8 * _CLOSED, 0) == 0 and _called(word(work + 8 * _LOOP), work) != 1:
        _added(work + 8 * _FAILED, 1)
    _added(work + 8 * _COMPUTING, -1)
    _release(work)
    return 0


@part()
def share(frame: int, task_slot: int) -> int:
    """Compute all parts of a frame by the task in a slot, with who comes to help.

    The caller's own share of it is to help as well. It waits for the task if another thread of
    Python has yet to compile it.
    """
    if answered(frame):
        return 0
    while _added(task_slot, 0) == 0:
        _sched_yield()
    api, context = word(frame + 8 * API), word(frame + 8 * CONTEXT)
    work, helper = _malloc(8 * WORDS), word(slot_of(HELP))
    helpers = max(0, min(_threads(api, context) - 1, MOST_THREADS))
    for place in range(WORDS):
        set_word(work + 8 * place, 0)
    set_word(work + 8 * FRAME, frame)
    set_word(work + 8 * _LOOP, word(task_slot))
    set_word(work + 8 * _HOLDERS, helpers + 2)
    for _ in range(helpers):
        _offer(api, context, helper, work)
    _called(helper, work)
    _added(work + 8 * _CLOSED, 1)
    while _added(work + 8 * _COMPUTING, 0) > 0:
        _sched_yield()
    if _added(work + 8 * _FAILED, 0) > 0:
        found = result(frame)
        for place in range(found.size):
            found[place] = math.nan
    _release(work)
    return 0


@part()
def _threads(api: int, context: int) -> int:
    """Number of XLA's threads; 1 if it does not say."""
    request = _malloc(8 * 5)
    _write(request, 8 * 4, context, request + 8 * 4, 1)
    failure = _called(word(api + 8 * NUMBER_OF_THREADS), request)
    count = word(request + 8 * 4) if failure == 0 else 1
    _free(request)
    return count


@part()
def _offer(api: int, context: int, address: int, work: int) -> None:
    """Let one of XLA's threads run a task for the work when it has time."""
    request = _malloc(8 * 5)
    _write(request, 8 * 5, context, address, work)
    if _called(word(api + 8 * SCHEDULE), request) != 0:
        _release(work)
    _free(request)


@part()
def _write(request: int, size: int, context: int, first: int, second: int) -> None:
    """What one of XLA's functions is asked with: its size, nothing beyond, and what it needs."""
    set_word(request, size)
    set_word(request + 8, 0)
    set_word(request + 16, context)
    set_word(request + 24, first)
    set_word(request + 32, second)
