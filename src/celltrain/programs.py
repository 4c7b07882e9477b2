"""Programs of JAX that commands keep, so that the next one need not trace them.

What XLA has compiled JAX keeps by the text that it compiled, which must be traced and lowered
first: for a simulation's programs that takes several times as long as loading them. Here a program
is found by all that the text follows from: the function and its arguments but for the numbers in
arrays, the sources of this package, the versions of the libraries, what the environment says to
them, and the processor. Where any of it is new, the program is made as ever, and kept.

Only commands keep programs (`environment.KEEPS_PROGRAMS`; not where `$CELLTRAIN_KEEP_PROGRAMS` is
0), on one processor: in other processes the package's functions may have been replaced, and
arguments may be of classes that are the user's.
"""

import hashlib
import io
import os
import pickle
import platform
import threading
import time
import zlib
from collections.abc import Callable, Hashable, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import cache, update_wrapper
from glob import escape
from pathlib import Path
from types import MethodType
from typing import Any, Generic, ParamSpec, Protocol, TypeVar

import equinox as eqx
import jax
import numpy as np
import scipy
from jax.experimental.serialize_executable import deserialize_and_load, serialize
from jaxlib import version as jaxlib_version
from jaxtyping import PyTree

from celltrain import environment
from celltrain.clock import compilation
from celltrain.runtime import only_processors, setting

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")
# From the arrays among the arguments to those of the result, and the result with their places.
_Loaded = tuple[Callable[[list[Any]], list[Any]], PyTree]

#: Programs that are kept; those not used for longest go.
MOST = 200
#: Age from which a file under way is nobody's.
LEFT_SECONDS = 3600.0
# Roots of the modules of which arguments may hold classes and functions.
_KNOWN = ("celltrain", "builtins", "numpy", "jax", "jaxlib", "equinox", "copyreg")
# Beginnings of the names of variables that say how programs are to be made.
_SETTINGS = ("JAX_", "XLA_", "CELLTRAIN_")
# Versions with which loaded programs were tried: what they need beside their code may change.
_JAXLIB = "0.10."


class Program(Generic[Arguments, Result]):
    """A function of trees of arrays, and of what else its arguments hold, that is compiled.

    Where programs are kept it is looked for there first (see the module).
    """

    def __init__(self, function: Callable[Arguments, Result]) -> None:
        self._function = function
        self._traced: Callable[Arguments, Result] = eqx.filter_jit(function)
        self._loaded: dict[Hashable, _Loaded | None] = {}
        self._one_at_a_time = threading.Lock()
        update_wrapper(self, function)

    def __call__(self, *arguments: Arguments.args, **named: Arguments.kwargs) -> Result:
        """What the function gives; arrays are arrays of JAX."""
        folder = _folder()
        leaves, tree = jax.tree.flatten((arguments, named))
        traced = any(isinstance(each, jax.core.Tracer) for each in leaves)
        if folder is None or traced:
            return self._traced(*arguments, **named)
        signature = (tree, tuple(_form(each) for each in leaves))
        with self._one_at_a_time:
            if signature not in self._loaded:
                self._loaded[signature] = self._found(folder, leaves, tree)
        loaded = self._loaded[signature]
        if loaded is None:
            return self._traced(*arguments, **named)
        run, result = loaded
        found = run([each for each in leaves if eqx.is_array(each)])
        return jax.tree.map(found.__getitem__, result)

    def __get__(self, instance: object, owner: type | None = None) -> Any:
        """Bound to an object like any function, for which Sphinx takes what can be bound."""
        return self if instance is None else MethodType(self, instance)

    def _found(self, folder: Path, leaves: list[Any], tree: Any) -> _Loaded | None:
        """The program for such arguments, loaded or made; None if it cannot be kept."""
        key = _key(self._function, tree.unflatten([_form(each) for each in leaves]))
        if key is None:
            return None
        arrays = [each for each in leaves if eqx.is_array(each)]
        path = folder / f"{self._function.__name__.strip('_')}-{key}-program"
        begin = time.perf_counter()
        loaded = _load(path, arrays)
        if loaded is not None:
            compilation.add(time.perf_counter() - begin)
            return loaded
        outcome: list[PyTree] = []

        def over_arrays(arrays: list[Any]) -> list[Any]:
            given = iter(arrays)
            every = [next(given) if eqx.is_array(each) else each for each in leaves]
            arguments, named = tree.unflatten(every)
            parts, structure = jax.tree.flatten(self._function(*arguments, **named))
            outcome.append(jax.tree.unflatten(structure, range(len(parts))))
            return parts

        # A name of its own, so that JAX does not take it from what it keeps itself: what XLA has
        # loaded cannot be written whole again.
        over_arrays.__name__ = f"{self._function.__name__}_{key}"
        before = _loads.number
        with _called() as called:
            lowered = jax.jit(over_arrays).lower(arrays)
            # Parts may have been traced before, for another program.
            called |= _called_in(lowered.as_text())
            compiled = lowered.compile()
            if _loads.number == before:
                _keep(path, compiled, outcome[0], called)
        for same in folder.glob(f"jit_{escape(over_arrays.__name__)}-*"):
            with suppress(OSError):
                same.unlink()
        return compiled, outcome[0]


class Callee(Protocol):
    """What programs call by its name, beside what XLA has itself."""

    @property
    def name(self) -> str:
        """What a program's text calls it."""
        ...

    def declare(self) -> None:
        """Let XLA find it, before a program that calls it is compiled or loaded."""

    def make(self) -> None:
        """Have it made, before a program that calls it runs."""


_callees: dict[str, Callee] = {}


class _Tracing(threading.local):
    """What a program calls that a thread traces; None if it traces none of those here."""

    called: set[str] | None = None


_tracing = _Tracing()


def offer(callee: Callee) -> None:
    """Let programs call something by its name."""
    _callees[callee.name] = callee


def call(callee: Callee) -> None:
    """Declare what is called by what is being traced, and have it made before that runs."""
    callee.declare()
    if _tracing.called is None:
        callee.make()
    else:
        _tracing.called.add(callee.name)


@contextmanager
def _called() -> Iterator[set[str]]:
    """Names of what is called by a program that is traced and compiled; all is made at the end."""
    before = _tracing.called
    names: set[str] = set()
    _tracing.called = names
    try:
        yield names
        _make(names)
    except BaseException:
        if names:
            # JAX would take what was traced for another program, which would wait for them.
            jax.clear_caches()
        raise
    finally:
        _tracing.called = before


def _make(names: Iterable[str]) -> None:
    """Have all of them made; last those with which another process begins (`compiled.ahead`)."""
    for name in reversed([each for each in _callees if each in names]):
        _callees[name].make()


def _called_in(text: str) -> set[str]:
    """Names of what a program's text calls."""
    return {name for name in _callees if name in text}


class _Loads:
    """How many programs JAX has loaded from those that it keeps."""

    def __init__(self) -> None:
        self.number = 0
        jax.monitoring.register_event_listener(self.listen)

    def listen(self, event: str, **_: str | int) -> None:
        """Take one of JAX's reports."""
        self.number += event == "/jax/compilation_cache/cache_hits"


_loads = _Loads()


def _folder() -> Path | None:
    """Where programs are kept, None if they are not."""
    known = environment.PROGRAMS
    if known is None or not environment.KEEPS_PROGRAMS or not only_processors():
        return None
    if not jaxlib_version.__version__.startswith(_JAXLIB):
        return None
    # Loaded programs run on one device, and neither step by step nor with JAX looking on.
    watched = ("jax_disable_jit", "jax_debug_nans", "jax_debug_infs")
    if jax.device_count() > 1 or any(setting(name) for name in watched):
        return None
    # The user may have given JAX another folder, or none.
    kept = setting("jax_enable_compilation_cache") and setting("jax_compilation_cache_dir")
    return Path(known) if kept == known else None


def _form(leaf: Any) -> Hashable:
    """What a program depends on of a leaf of its arguments."""
    if not eqx.is_array(leaf):
        return leaf
    return leaf.shape, str(leaf.dtype), getattr(leaf, "weak_type", False)


class _Pickler(pickle.Pickler):
    """Refuses what may mean something else in the next process."""

    def reducer_override(self, value: Any) -> Any:
        owner = value if isinstance(value, type) or callable(value) else type(value)
        module = str(getattr(owner, "__module__", None) or "builtins")
        if module.split(".")[0] not in _KNOWN:
            raise pickle.PicklingError(f"{module} may change")
        return NotImplemented


def _key(function: Callable[..., Any], forms: PyTree) -> str | None:
    """The name of a program; None for arguments that cannot be told apart in another process."""
    foundation = _foundation()
    if foundation is None:
        return None
    written = io.BytesIO()
    try:
        _Pickler(written).dump((function.__module__, function.__qualname__, forms))
    except Exception:  # whatever of the arguments cannot be written
        return None
    settings = sorted(each for each in os.environ.items() if each[0].startswith(_SETTINGS))
    return _digest(written.getvalue() + foundation + repr(settings).encode()).hex()


@cache
def _foundation() -> bytes | None:
    """What all programs depend on: sources, libraries, the processor; None if that is not known."""
    from llvmlite import binding

    libraries = (jax, jaxlib_version, eqx, np, scipy)
    versions = [platform.python_version(), *(each.__version__ for each in libraries)]
    processor = [binding.get_host_cpu_name(), binding.get_host_cpu_features().flatten()]
    package = Path(__file__).parent
    try:
        sources = [
            (str(each.relative_to(package)), _digest(each.read_bytes()))
            for each in sorted(package.rglob("*.py"))
        ]
    except OSError:
        return None
    if not sources or _changed_since():
        return None
    return _digest(repr((versions, processor, sources)).encode())


def _changed_since() -> bool:
    """Whether a source has changed since it may have been imported."""
    try:
        times = [each.stat() for each in Path(__file__).parent.rglob("*.py")]
    except OSError:
        return True
    return any(max(each.st_mtime, each.st_ctime) >= environment.STARTED for each in times)


def _digest(content: bytes) -> bytes:
    return hashlib.blake2b(content, digest_size=16).digest()


def _load(path: Path, arrays: list[Any]) -> _Loaded | None:
    """The program of a file; None if there is none, or it is damaged, and then removed."""
    try:
        packed = path.read_bytes()
    except OSError:
        return None
    _load_lapack()
    try:
        # It has a checksum.
        executable, result, called = pickle.loads(zlib.decompress(packed))
        for name in called:
            _callees[name].declare()
        inward = jax.tree.structure(((arrays,), {}))
        outward = jax.tree.structure([0] * len(jax.tree.leaves(result)))
        loaded = deserialize_and_load(executable, inward, outward)
    except Exception:  # whatever a library finds wrong with it: the program is made anew
        with suppress(OSError):
            path.unlink()
        return None
    _make(called)
    with suppress(OSError):
        os.utime(path)
    return loaded, result


@cache
def _load_lapack() -> None:
    """Let JAX find LAPACK, which it does when it lowers a call of it; a program would not."""
    jax.jit(jax.lax.linalg.cholesky).lower(jax.ShapeDtypeStruct((1, 1), float))


def _keep(path: Path, compiled: jax.stages.Compiled, result: PyTree, called: set[str]) -> None:
    """Write a program, and remove those not used for longest; nothing where that cannot be.

    `called`: names of what it calls.
    """
    part = path.with_name(f"{path.name}.{os.getpid()}")
    if _changed_since():
        return
    try:
        executable = serialize(compiled)[0]
        packed = zlib.compress(pickle.dumps((executable, result, called)), level=1)
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            part.write_bytes(packed)
            part.replace(path)
        finally:
            part.unlink(missing_ok=True)
        kept = sorted(path.parent.glob("*-program"), key=lambda each: each.stat().st_mtime)
        for old in kept[:-MOST]:
            old.unlink()
        # What processes that were killed have left.
        for old in path.parent.glob("*-program.*"):
            if time.time() - old.stat().st_mtime > LEFT_SECONDS:
                old.unlink()
    except Exception:  # whatever goes wrong: it is only not kept
        return
