"""Compiled loops where they can be called, plain formulas elsewhere, and how that is told."""

import re
import subprocess
import sys
from functools import partial
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain import programs
from celltrain.compiled import LOOPS_SERVE, dispatch, loop
from celltrain.compiled.call_frame import differences
from celltrain.compiled.header import HEADER, Header
from celltrain.compiled.loops import (
    FORCE_PAIRS,
    INTERPOLATE,
    OWN_FORCES,
    SPREAD,
    STRESSLET_PAIRS,
)
from celltrain.flow import OwnSurfaceRule, own_surface_rule
from celltrain.flow.near import NearPairs, pair_sums
from celltrain.flow.nonuniform import modes_to_points, points_to_modes
from celltrain.flow.own_surface import own_velocity
from celltrain.proximity.close_pairs import LeftOut

XI, CUTOFF = 1.1, 2.0
INCLUDE = Path(jax.ffi.include_dir())
TEXT = (INCLUDE / HEADER).read_text()


Arrays = tuple[jax.Array, ...]
OnSurface = tuple[OwnSurfaceRule, jax.Array, jax.Array, jax.Array, jax.Array]
by_near_pairs = partial(pair_sums, XI, CUTOFF)


def inputs() -> tuple[tuple[jax.Array | NearPairs, ...], OnSurface]:
    """Of `pair_sums`, with forces and stresslets, and of `own_velocity`."""
    random = np.random.default_rng(5)
    sizes = (3, 4, 3), (2, 6, 3), (2, 6, 3), (2, 6, 6)
    points = [jnp.asarray(random.normal(size=each)) for each in sizes]
    near = jnp.asarray(random.random((3, 3, 2)) < 0.5)
    rows = jnp.asarray(random.integers(-1, 5, (3, 3, 2)))
    left_out = LeftOut(rows, jnp.asarray(random.random((5, 4)) < 0.3))
    pairs = NearPairs(near, jnp.asarray([0, 1]), left_out)
    rule = own_surface_rule(3, np.array([0.4, 2.0]), radial=3, azimuthal=4, parameter=XI)
    sizes = (2, 2, 3, 3), (3,), (2, 3, 9), (2, 3, 9)
    targets, longitudes, shapes, forces = (jnp.asarray(random.normal(size=each)) for each in sizes)
    on_surface = rule, targets, longitudes, shapes, forces
    return (*points, jnp.asarray(2.0), pairs), on_surface


def there_and_back(angles: jax.Array, values: jax.Array) -> jax.Array:
    """Values at points to modes, and back to values there."""
    angles, values = angles.reshape(-1, 3), values.reshape(-1, 3)
    return modes_to_points(points_to_modes((1, 1, 1), values, angles, 1e-3), angles, 1e-3)


def sums() -> Arrays:
    """Both sums."""
    by_pairs, on_surface = inputs()
    return jax.jit(by_near_pairs)(*by_pairs), jax.jit(own_velocity)(*on_surface)


def doctored(folder: Path, text: str) -> Path:
    """A folder of headers, with this text in place of the one that matters."""
    (folder / HEADER).parent.mkdir(parents=True)
    (folder / HEADER).write_text(text)
    return folder


def changed(old: str, new: str) -> str:
    assert len(re.findall(old, TEXT)) == 1, old
    return re.sub(old, new, TEXT)


def test_the_installed_header_is_what_the_loops_are_written_for() -> None:
    assert differences(INCLUDE) == []
    assert LOOPS_SERVE


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (r"(#define XLA_FFI_API_MAJOR) 0", r"\1 1", "XLA_FFI_API_MAJOR is 1 instead of 0"),
        (r"(#define XLA_FFI_API_MINOR) \d", r"\1 2", "XLA_FFI_API_MINOR is 2 instead of 3 or 4"),
        (r"(#define XLA_FFI_API_MINOR) \d", r"\1 5", "XLA_FFI_API_MINOR is 5 instead of 3 or 4"),
        (r"(#define) XLA_FFI_API_MINOR \d", r"\1 OTHER 3", "XLA_FFI_API_MINOR is None"),
        (r"(XLA_FFI_Extension_Metadata) = 1", r"\1 = 7", "XLA_FFI_Extension_Metadata is 7"),
        # A field more, fields exchanged, another size, another name, and none at all.
        (
            r"(XLA_FFI_DataType dtype;)(\s*void\* data;\s*int64_t rank;)",
            r"\1 int64_t more;\2",
            "XLA_FFI_Buffer.data is at byte 32 instead of 24",
        ),
        (
            r"(int64_t rank;)\s*(int64_t\* dims;)",
            r"\2 \1",
            "XLA_FFI_Buffer.rank is at byte 40 instead of 32",
        ),
        (
            r"XLA_FFI_ExecutionStage stage;(\s*XLA_FFI_Args args;)",
            r"XLA_FFI_Args stage;\1",
            "XLA_FFI_CallFrame.args.args is at byte 104 instead of 72",
        ),
        (r"void\*\* rets; ", r"void** results; ", "XLA_FFI_Rets has no field rets"),
        (r"struct XLA_FFI_Buffer \{", r"struct Other {", "there is no structure XLA_FFI_Buffer"),
        (r"int64_t rank;", r"unheard_of rank;", "the size of unheard_of is not known"),
    ],
)
def test_another_header_is_told_apart(tmp_path: Path, old: str, new: str, said: str) -> None:
    found = differences(doctored(tmp_path, changed(old, new)))
    assert any(said in each for each in found), found


def test_both_versions_of_the_interface_serve(tmp_path: Path) -> None:
    """By their numbers and their names of what extends a frame."""
    minor, base, later = "XLA_FFI_API_MINOR", "XLA_FFI_Extension_Base", "XLA_FFI_InternalExtension"
    here = Header(TEXT).numbers[minor]
    for number, name in ((3, base), (4, later)):
        text = re.sub(rf"{base}|{later}", name, TEXT).replace(
            f"{minor} {here}", f"{minor} {number}"
        )
        assert differences(doctored(tmp_path / name, text)) == []
    wrong = text.replace(later, base)
    assert differences(doctored(tmp_path / "wrong", wrong)) == [f"there is no structure {later}"]


def test_no_header(tmp_path: Path) -> None:
    assert "cannot be read" in differences(tmp_path)[0]


def test_places_are_those_of_a_compiler() -> None:
    header = Header("""
        // struct Inner { int64_t not_this; };
        typedef enum { First = 3, Second = 4 } Kind;
        struct Inner { int32_t a; /* int64_t b; */ const char* c; Kind kind; };
        struct Outer { Kind kind; struct Inner inner; int32_t last; uint8_t* end; };
    """)
    assert header.numbers == {"First": 3, "Second": 4}
    places = {"kind": 0, "inner": 8, "inner.c": 16, "inner.kind": 24, "last": 32, "end": 40}
    assert {path: header.offset("Outer", path) for path in places} == places


def test_without_loops_formulas_give_the_same(tmp_path: Path) -> None:
    """A package whose jaxlib has another header says so, and computes the same sums."""
    folder = doctored(tmp_path, changed(r"(#define XLA_FFI_API_MINOR) \d+", r"\1 5"))
    program = f"""
import runpy, warnings
import jax, numpy
from functools import partial
jax.ffi.include_dir = lambda: {str(folder)!r}
with warnings.catch_warnings(record=True) as told:
    warnings.simplefilter("always")
    here = runpy.run_path({__file__!r})
assert not here["LOOPS_SERVE"]
(message,) = [each for each in told if "compiled loops" in str(each.message)]
assert message.category is RuntimeWarning
print(message.message)
by_pairs, _ = here["inputs"]()
traced = jax.jit(here["by_near_pairs"]).lower(*by_pairs)
assert "celltrain_" not in traced.as_text()
numpy.savez({str(tmp_path / "sums.npz")!r}, *here["sums"]())
"""
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "XLA_FFI_API_MINOR is 5 instead of 3 or 4" in done.stdout
    with np.load(tmp_path / "sums.npz") as kept:
        for number, expected in enumerate(sums()):
            size = np.abs(expected).max()
            assert size > 0.1
            assert_allclose(kept[f"arr_{number}"], expected, rtol=0, atol=1e-12 * size)


@pytest.mark.parametrize("platform", ["cuda", "rocm", "tpu"])
def test_other_platforms_get_formulas(platform: str, monkeypatch: pytest.MonkeyPatch) -> None:
    # As where there is another platform beside the processors.
    monkeypatch.setattr(dispatch, "only_processors", lambda: False)
    by_pairs, on_surface = inputs()
    for function, given, loops, formula in (
        (by_near_pairs, by_pairs, (FORCE_PAIRS, STRESSLET_PAIRS), "stablehlo.rsqrt"),
        (own_velocity, on_surface, (OWN_FORCES,), "stablehlo.rsqrt"),
        (there_and_back, by_pairs[1:3], (SPREAD, INTERPOLATE), "stablehlo.scatter"),
    ):
        # Of its own, or what another test has traced would be taken.
        traced = jax.jit(partial(function)).trace(*given)
        here = traced.lower(lowering_platforms=("cpu",)).as_text()
        there = traced.lower(lowering_platforms=(platform,)).as_text()
        for each in loops:
            assert each.name in here
            assert each.name not in there
        assert programs._called_in(here) == {each.name for each in loops}
        assert programs._called_in(there) == set()
        # What is not taken is not computed, either: the loop stands for the whole formula.
        assert formula in there
        assert formula not in here


def test_no_choice_is_left_to_the_program() -> None:
    for function, given in zip((by_near_pairs, own_velocity), inputs(), strict=True):
        program = jax.jit(function).lower(*given).compile().as_text()
        assert "custom-call" in program
        assert "conditional(" not in program


def test_many_at_once() -> None:
    _, (rule, targets, *rest) = inputs()
    several = jnp.stack([targets, 2.0 * targets, -targets])
    found = jax.jit(jax.vmap(lambda each: own_velocity(rule, each, *rest)))(several)
    expected = jnp.stack([own_velocity(rule, each, *rest) for each in several])
    assert_allclose(found, expected, rtol=1e-13)


def test_arguments_of_another_type_are_refused() -> None:
    _, (rule, targets, longitudes, shapes, forces) = inputs()
    both = jnp.concatenate([shapes, forces], axis=1)
    tables = rule.rotations, rule.tables.latitude, rule.tables.longitude, rule.weights
    given = targets, both, longitudes, *tables, jnp.asarray(XI)
    assert np.isfinite(loop(OWN_FORCES, targets.shape, *given)).all()
    for number in range(len(given)):
        other = list(given)
        other[number] = other[number].astype(jnp.float32)
        with pytest.raises(TypeError, match=f"{OWN_FORCES.name} is given .*float32"):
            loop(OWN_FORCES, targets.shape, *other)
