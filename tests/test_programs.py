"""Programs that commands keep: found again only where nothing they depend on has changed."""

import os
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import xarray as xr
from jax.experimental.compilation_cache import compilation_cache

from celltrain import environment, programs
from celltrain.programs import Program

traced: list[str] = []


class Pair(eqx.Module):
    first: jax.Array
    second: Any
    name: str = eqx.field(static=True)


def spectrum(pair: Pair, amount: int) -> Pair:
    """Something with LAPACK in it, and with a tree for its result."""
    traced.append(pair.name)
    values, vectors = jnp.linalg.eigh(pair.first * amount)
    return Pair(values, {"vectors": vectors, "given": pair.second}, pair.name)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Programs are kept in a folder of the test's own, by JAX, too."""
    kept = tmp_path / "compiled"
    names = ("jax_compilation_cache_dir", "jax_persistent_cache_min_compile_time_secs")
    before = [getattr(jax.config, name) for name in names]
    monkeypatch.setattr(environment, "KEEPS_PROGRAMS", True)
    monkeypatch.setattr(environment, "PROGRAMS", str(kept))
    # What this file brings is as good as the package's own.
    monkeypatch.setattr(programs, "_KNOWN", (*programs._KNOWN, Pair.__module__.split(".")[0]))
    for name, setting in zip(names, (str(kept), 0.0), strict=True):
        jax.config.update(name, setting)
    compilation_cache.reset_cache()
    traced.clear()
    yield kept
    for name, setting in zip(names, before, strict=True):
        jax.config.update(name, setting)
    compilation_cache.reset_cache()


def symmetric(size: int = 4) -> jax.Array:
    matrix = np.random.default_rng(0).normal(size=(size, size))
    return jnp.asarray(matrix + matrix.T)


def pair(size: int = 4, name: str = "some", second: Any = 1.0) -> Pair:
    return Pair(symmetric(size), jnp.asarray(second), name)


def kept(folder: Path) -> list[Path]:
    return sorted(folder.glob("*-program"))


def test_the_next_process_does_not_trace_and_finds_the_same(folder: Path) -> None:
    made = Program(spectrum)(pair(), 2)
    assert len(kept(folder)) == 1
    found = Program(spectrum)(pair(), 2)
    assert traced == ["some"]
    assert found.name == "some"
    assert eqx.tree_equal(made, found)
    np.testing.assert_allclose(found.first, np.linalg.eigvalsh(2 * np.asarray(symmetric())))
    # Other numbers in the arrays are other data for the same program.
    other = Program(spectrum)(pair(second=7.0), 2)
    assert (traced, float(other.second["given"])) == (["some"], 7.0)


@dataclass(frozen=True)
class Noted:
    """What programs call, with what is asked of it."""

    name: str
    asked: list[str]

    def declare(self) -> None:
        self.asked.append(f"declare {self.name}")

    def make(self) -> None:
        # Of a program that is there.
        self.asked.append(f"make {self.name}")


def calling(values: jax.Array) -> jax.Array:
    traced.append("calling")
    programs.call(programs._callees["first"])
    programs.call(programs._callees["second"])
    return 2.0 * jnp.linalg.eigvalsh(values)


def test_what_a_program_calls_is_made_when_it_has_been_compiled(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[str] = []
    monkeypatch.setattr(programs, "_callees", {})
    for name in ("first", "second", "lapack_dsyevd", "never_called"):
        programs.offer(Noted(name, asked))
    compiled = jax.stages.Lowered.compile

    def compile_and_note(lowered: jax.stages.Lowered) -> jax.stages.Compiled:
        asked.append("compile")
        return compiled(lowered)

    monkeypatch.setattr(jax.stages.Lowered, "compile", compile_and_note)
    Program(calling)(symmetric())
    # The last to be called first; what the text names was declared by who traced that part.
    made = ["make lapack_dsyevd", "make second", "make first"]
    assert asked == ["declare first", "declare second", "compile", *made]
    asked.clear()
    Program(calling)(symmetric())
    assert traced == ["calling"]
    assert set(asked[:3]) == {"declare first", "declare second", "declare lapack_dsyevd"}
    assert asked[3:] == made


@pytest.mark.parametrize("failing", ["compile", "make"])
def test_what_was_traced_for_a_program_that_failed_is_traced_anew(
    failing: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Or another one would take it, and wait for what it calls."""
    full = [failing == "make"]

    class Failing(Noted):
        def make(self) -> None:
            super().make()
            if full[0]:
                raise OSError("no space left")

    asked: list[str] = []
    monkeypatch.setattr(programs, "_callees", {})
    for name in ("first", "second"):
        programs.offer(Failing(name, asked))
    # Of its own, or what another test has traced would be taken.
    inner = jax.jit(partial(calling))

    def outer(values: jax.Array) -> jax.Array:
        return inner(values)

    with monkeypatch.context() as patch:
        if failing == "compile":
            patch.setattr(jax.stages.Lowered, "compile", None)
        with pytest.raises((TypeError, OSError)):
            Program(outer)(symmetric())
    full[0] = False
    assert asked[:2] == ["declare first", "declare second"]
    asked.clear()
    inner(symmetric())
    assert asked == ["declare first", "make first", "declare second", "make second"]


def test_within_a_process_it_is_looked_for_once(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    one = Program(spectrum)
    one(pair(), 2)
    monkeypatch.setattr(programs, "_load", None)
    monkeypatch.setattr(programs, "_key", None)
    assert eqx.tree_equal(one(pair(), 2), one(pair(), 2))
    assert traced == ["some"]


@pytest.mark.parametrize(
    "changed",
    [
        (pair(size=5), 2),
        (pair(name="another"), 2),
        (pair(), 3),
        (pair(second=[1.0]), 2),
        (pair(second=1), 2),
        (pair(), 2.0),
        (Pair(symmetric(), jnp.asarray(np.ones(())), "some"), 2),
        (Pair(symmetric(), None, "some"), 2),
    ],
    ids=["shape", "name", "number", "rank", "integer", "float", "strong", "absent"],
)
def test_programs_of_other_arguments_are_others(folder: Path, changed: tuple[Any, ...]) -> None:
    Program(spectrum)(pair(), 2)
    Program(spectrum)(*changed)
    assert len(kept(folder)) == len(traced) == 2


def test_what_programs_are_made_from_tells_them_apart(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    Program(spectrum)(pair(), 2)
    monkeypatch.setenv("XLA_FLAGS", "--xla_cpu_enable_fast_math=false")
    Program(spectrum)(pair(), 2)
    monkeypatch.setattr(programs, "_foundation", lambda: b"other sources")
    Program(spectrum)(pair(), 2)
    assert len(kept(folder)) == len(traced) == 3


def test_every_source_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "celltrain"
    (package / "flow").mkdir(parents=True)
    (package / "flow" / "near.py").write_text("1")
    monkeypatch.setattr(programs, "__file__", str(package / "programs.py"))
    monkeypatch.setattr(environment, "STARTED", float("inf"))
    programs._foundation.cache_clear()
    first = programs._foundation()
    (package / "flow" / "near.py").write_text("2")
    programs._foundation.cache_clear()
    assert programs._foundation() != first
    # What was imported may be older than a source that has changed since.
    monkeypatch.setattr(environment, "STARTED", 0.0)
    programs._foundation.cache_clear()
    assert programs._foundation() is None
    monkeypatch.setattr(environment, "STARTED", float("inf"))
    # Nor may anything be kept where sources cannot be read, or are not there.
    (package / "flow" / "gone.py").symlink_to("nowhere")
    programs._foundation.cache_clear()
    assert programs._foundation() is None
    (package / "flow" / "gone.py").unlink()
    (package / "flow" / "near.py").unlink()
    programs._foundation.cache_clear()
    assert programs._foundation() is None
    monkeypatch.undo()
    programs._foundation.cache_clear()


@pytest.mark.parametrize("damage", ["", "some text", "cut", "flipped"])
def test_damaged_programs_are_made_anew(folder: Path, damage: str) -> None:
    made = Program(spectrum)(pair(), 2)
    (path,) = kept(folder)
    whole = path.read_bytes()
    middle = len(whole) // 2
    flipped = whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1 :]
    path.write_bytes({"cut": whole[:-1], "flipped": flipped}.get(damage, damage.encode()))
    assert eqx.tree_equal(Program(spectrum)(pair(), 2), made)
    assert traced == ["some", "some"]
    # And kept again, though JAX has compiled the same before.
    assert kept(folder) == [path]
    assert eqx.tree_equal(Program(spectrum)(pair(), 2), made)
    assert traced == ["some", "some"]


def test_sources_that_change_meanwhile_leave_nothing(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(programs, "_changed_since", lambda: True)
    Program(spectrum)(pair(), 2)
    assert kept(folder) == []


def test_threads_trace_once(folder: Path) -> None:
    one = Program(spectrum)
    with ThreadPoolExecutor(6) as pool:
        found = list(pool.map(lambda number: one(pair(second=number), 2), np.arange(6.0)))
    assert traced == ["some"]
    assert [float(each.second["given"]) for each in found] == list(range(6))


def test_arguments_of_classes_of_others_are_not_trusted(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(programs, "_KNOWN", ("celltrain", "builtins", "jax", "jaxlib"))
    found = Program(spectrum)(pair(), 2)
    assert kept(folder) == []
    np.testing.assert_allclose(found.first, np.linalg.eigvalsh(2 * np.asarray(symmetric())))


def test_what_cannot_be_told_apart_is_not_kept(folder: Path) -> None:
    def inner(x: jax.Array) -> jax.Array:
        return 2 * x

    assert float(Program(lambda f, x: f(x))(inner, jnp.asarray(1.0))) == 2.0
    assert kept(folder) == []


def test_derivatives_go_through_the_function(folder: Path) -> None:
    def energy(first: jax.Array) -> jax.Array:
        return Program(spectrum)(Pair(first, None, "some"), 1).first.sum()

    np.testing.assert_allclose(jax.grad(energy)(symmetric()), np.eye(4), atol=1e-12)
    assert kept(folder) == []


def test_nothing_is_kept_where_it_is_not_wanted(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(environment, "KEEPS_PROGRAMS", False)
    Program(spectrum)(pair(), 2)
    monkeypatch.setattr(environment, "KEEPS_PROGRAMS", True)
    for name in ("jax_disable_jit", "jax_debug_nans"):
        jax.config.update(name, True)
        Program(spectrum)(pair(), 2)
        jax.config.update(name, False)
    for where, name, other in (
        (jax, "device_count", lambda: 2),
        (programs, "only_processors", lambda: False),
        (programs, "_JAXLIB", "0.9."),
    ):
        with monkeypatch.context() as patch:
            patch.setattr(where, name, other)
            Program(spectrum)(pair(), 2)
    jax.config.update("jax_enable_compilation_cache", False)
    Program(spectrum)(pair(), 3)
    jax.config.update("jax_enable_compilation_cache", True)
    monkeypatch.setattr(environment, "PROGRAMS", str(folder / "elsewhere"))
    Program(spectrum)(pair(), 4)
    assert not list(folder.rglob("*-program"))


def test_a_program_that_jax_had_is_not_kept(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """XLA cannot write what it has itself loaded: without its machine code it would fail."""

    unlink = Path.unlink
    # As where a process was killed before it removed what JAX keeps of the program.
    monkeypatch.setattr(Path, "unlink", lambda *_, **__: None)
    Program(spectrum)(pair(), 2)
    (path,) = kept(folder)
    unlink(path)
    monkeypatch.setattr(Path, "unlink", unlink)
    Program(spectrum)(pair(), 2)
    assert kept(folder) == []
    # The next one finds neither.
    Program(spectrum)(pair(), 2)
    assert kept(folder) == [path]
    assert not list(folder.glob("jit_spectrum*"))


def test_those_not_used_for_longest_go(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(programs, "MOST", 2)
    for number in (1, 2):
        Program(spectrum)(pair(), number)
    first, second = sorted(kept(folder), key=lambda each: each.stat().st_mtime)
    os.utime(first, (1, 1))
    os.utime(second, (2, 2))
    Program(spectrum)(pair(), 1)  # used again
    Program(spectrum)(pair(), 3)
    assert first in kept(folder)
    assert len(kept(folder)) == 2
    assert second not in kept(folder)


def test_what_killed_processes_left_goes(folder: Path) -> None:
    folder.mkdir()
    old, new = (folder / f"rates-{name}-program.123" for name in ("old", "new"))
    for each in (old, new):
        each.write_bytes(b"half")
    os.utime(old, (1, 1))
    Program(spectrum)(pair(), 2)
    assert (old.exists(), new.exists()) == (False, True)


@pytest.mark.slow
def test_a_simulation_begins_without_tracing_and_gives_the_same(tmp_path: Path) -> None:
    """Every program of the command, among them compiled loops, transforms and LAPACK's parts."""
    case = "--diameter 6 --packing 0.2 --cells 1 --degree 6 --viscosity-ratio 5 --until 0.05"
    surroundings = os.environ | {"XDG_CACHE_HOME": str(tmp_path), "JAX_LOG_COMPILES": "1"}
    del surroundings["CELLTRAIN_KEEP_PROGRAMS"]

    def simulated() -> tuple[xr.Dataset, str]:
        path = tmp_path / "run.nc"
        command = [sys.executable, "-m", "celltrain", "evolve", *case.split(), "--quiet"]
        done = subprocess.run(
            [*command, "--overwrite", "-o", path],
            capture_output=True,
            text=True,
            check=True,
            env=surroundings,
        )
        data = xr.load_dataset(path, decode_times=False)
        times = [name for name in data.variables if str(name).endswith("seconds")]
        assert times
        return data.drop_vars(times), done.stderr

    names = [f"jit(_{name}" for name in ("rates", "settle", "measure")]
    made, log = simulated()
    assert all(name in log for name in names)
    found, log = simulated()
    assert not any(name in log for name in names)
    xr.testing.assert_equal(made, found)
