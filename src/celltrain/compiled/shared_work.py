"""Work of one compiled loop, shared with the threads that XLA keeps for its programs.

XLA calls a loop in one thread, and often has nothing to run beside it. A loop whose work is made of
independent parts lets others take parts of it,

    @task("name")
    def task_of_loop(work_address):
        return computed(loop, work_address)

    @handler("name")
    def handler_of_loop(frame_address):
        return shared(frame_address, (FLOATS,), task_address("name"))

where `loop(frame_address, work_address)` computes the parts whose numbers `next_part` gives it
until there are none left. Which thread computes a part changes nothing in it. Nobody waits for a
thread to come: the caller takes parts as the others do, and when none is left it waits for those
that are being computed. A task that XLA runs only then finds the work closed. What all share is a
few words, released by the last.
"""

from collections.abc import Callable
from typing import Any, TypeAlias

import llvmlite.binding
from llvmlite import ir
from numba import cfunc, njit, types
from numba.core import cgutils
from numba.core.typing import Context
from numba.extending import intrinsic

from celltrain.compiled.call_frame import (
    API,
    CONTEXT,
    LOOPS_SERVE,
    NUMBER_OF_THREADS,
    SCHEDULE,
    Loop,
    answered,
    words,
)

# Types of what an intrinsic is called with and returns, and what writes its code.
IntrinsicParts: TypeAlias = tuple[types.FunctionType, Callable[..., ir.Value]]

# Words of the work: the loop's frame, the next part, threads that compute, whether it is closed,
# and who still holds its address.
_FRAME, _NEXT, _COMPUTING, _CLOSED, _HOLDERS, _WORDS = 0, 1, 2, 3, 4, 5
# Threads to which parts are offered; more would find little to do.
_MOST_THREADS = 16

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
def task_address(typing_context: Context, name: types.Type) -> IntrinsicParts:
    """Address of the task of a name, which the machine code finds when it is loaded."""
    symbol = _symbol(name.literal_value)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        word = ir.IntType(64)
        function = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(word, [word]), symbol
        )
        return builder.ptrtoint(function, word)

    return types.int64(name), generate


def _symbol(name: str) -> str:
    return f"{name}_task"


def task(name: str) -> Callable[[Loop], Loop]:
    """Compile the task of a name, and let machine code find it, if loops serve here."""

    def compiled(function: Loop) -> Loop:
        if not LOOPS_SERVE:
            return function
        signature = types.int64(types.int64)
        try:
            made = cfunc(signature, cache=True)(function)
        except RuntimeError:
            # Nowhere to keep the machine code: it is made anew in every process.
            made = cfunc(signature)(function)
        llvmlite.binding.add_symbol(_symbol(name), made.address)
        return made

    return compiled


@njit
def next_part(work: int) -> int:
    """Number of a part that nobody has taken yet, counted on beyond the last."""
    return _added(work + 8 * _NEXT, 1)


@njit
def computed(loop: Callable[[int, int], int], work: int) -> int:
    """Run a loop on the parts that it can get, unless the work is closed already."""
    _added(work + 8 * _COMPUTING, 1)
    # Only then: who closes the work waits for all that are counted.
    if _added(work + 8 * _CLOSED, 0) == 0:
        loop(words(work, _WORDS)[_FRAME], work)
    _added(work + 8 * _COMPUTING, -1)
    _release(work)
    return 0


@njit
def _release(work: int) -> None:
    if _added(work + 8 * _HOLDERS, -1) == 1:
        _free(work)


@njit
def shared(frame: int, kinds: tuple[int, ...], address: int) -> int:
    """Compute all parts of a frame by the task at an address, with who comes to help.

    The caller's own share of it is one more run of the task. `kinds`: types of the arguments.
    """
    if answered(frame, kinds):
        return 0
    caller = words(frame, CONTEXT + 1)
    api, context = caller[API], caller[CONTEXT]
    work = _malloc(8 * _WORDS)
    state = words(work, _WORDS)
    helpers = max(0, min(_threads(api, context) - 1, _MOST_THREADS))
    state[_FRAME], state[_NEXT], state[_COMPUTING], state[_CLOSED] = frame, 0, 0, 0
    state[_HOLDERS] = helpers + 2
    for _ in range(helpers):
        _offer(api, context, address, work)
    _called(address, work)
    _added(work + 8 * _CLOSED, 1)
    while _added(work + 8 * _COMPUTING, 0) > 0:
        _sched_yield()
    _release(work)
    return 0


@njit
def _threads(api: int, context: int) -> int:
    """Number of XLA's threads; 1 if it does not say."""
    request = _malloc(8 * 5)
    given = words(request, 5)
    given[0], given[1], given[2], given[3], given[4] = 8 * 4, 0, context, request + 8 * 4, 1
    failure = _called(words(api, NUMBER_OF_THREADS + 1)[NUMBER_OF_THREADS], request)
    count = given[4] if failure == 0 else 1
    _free(request)
    return count


@njit
def _offer(api: int, context: int, address: int, work: int) -> None:
    """Let one of XLA's threads run the task when it has time."""
    request = _malloc(8 * 5)
    given = words(request, 5)
    given[0], given[1], given[2], given[3], given[4] = 8 * 5, 0, context, address, work
    if _called(words(api, SCHEDULE + 1)[SCHEDULE], request) != 0:
        _release(work)
    _free(request)
