import json
import os
import re
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields, is_dataclass, replace
from io import StringIO
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pytest
import xarray as xr
from jaxtyping import Complex, Float
from rich.console import Console

from celltrain import load, show
from celltrain.contract import kinds, presentation
from celltrain.contract.tables import verdict_line
from celltrain.quantities import Quantity, Record, equal, quantities, quantity_of
from celltrain.quantities.fields import hints
from celltrain.results import from_dataset, save, summary, to_dataset
from celltrain.results.columns import from_variables, to_variables, walk
from celltrain.results.netcdf import FORM, ForeignFile
from celltrain.stability import Stability
from celltrain.stability.verdict import verdict
from celltrain.steady import Base


def assert_identical(first: Any, second: Any, where: str = "result") -> None:
    """Equal in type and in every bit, all the way down."""
    if isinstance(first, np.ndarray):
        assert isinstance(second, np.ndarray), where
        assert first.dtype == second.dtype, where
        assert first.shape == second.shape, where
        assert np.ascontiguousarray(first).tobytes() == np.ascontiguousarray(second).tobytes(), (
            where
        )
        return
    assert type(first) is type(second), where
    if is_dataclass(first):
        for field in fields(first):
            name = field.name
            assert_identical(getattr(first, name), getattr(second, name), f"{where}.{name}")
    elif isinstance(first, dict):
        assert list(first) == list(second), where
        for key in first:
            assert_identical(first[key], second[key], f"{where}[{key!r}]")
    elif isinstance(first, tuple):
        assert len(first) == len(second), where
        for place, pair in enumerate(zip(first, second, strict=True)):
            assert_identical(*pair, f"{where}[{place}]")
    elif isinstance(first, float):
        assert first.hex() == second.hex(), where
    elif isinstance(first, complex):
        assert (first.real.hex(), first.imag.hex()) == (second.real.hex(), second.imag.hex()), where
    else:
        assert first == second, where


def test_base_survives_a_file_bit_for_bit(make_base: Callable[..., Base], tmp_path: Path) -> None:
    base = make_base(diameter=6.1, packing=0.1 + 0.2, shear_modulus=1 / 3)
    assert_identical(load(save(base, tmp_path / "base.nc")), base)


def test_base_without_history_survives(make_base: Callable[..., Base], tmp_path: Path) -> None:
    base = replace(make_base(), history=())
    assert_identical(load(save(base, tmp_path / "base.nc")), base)


def test_stability_survives_a_file_bit_for_bit(
    make_stability: Callable[..., Stability], tmp_path: Path
) -> None:
    result = make_stability()
    assert_identical(load(save(result, tmp_path / "result.nc")), result)


def test_every_number_of_a_file_says_what_it_is(
    make_stability: Callable[..., Stability], tmp_path: Path
) -> None:
    path = save(make_stability(), tmp_path / "result.nc")
    known = {name: quantity_of(kind, field).meaning for name, kind, field in walk(Stability)}
    seen = set()
    with xr.open_dataset(path, engine="netcdf4") as data:
        for name, variable in data.variables.items():
            stem = re.sub(r"(_m\d\d)?(_real|_imag)?$", "", str(name))
            if stem not in known:
                # How parts are counted and named.
                assert re.search("_(count|key|train)$", stem), name
                continue
            seen.add(stem)
            assert variable.attrs["units"] == known[stem].unit
            assert variable.attrs["long_name"].startswith(known[stem].description)
            assert variable.attrs["symbol"] == known[stem].symbol
    # What consists of further fields has no variable of its own.
    assert set(known) - seen == {"modes", "error_bars"}


@pytest.mark.parametrize("kind", kinds())
def test_every_number_of_every_result_has_a_meaning(kind: str) -> None:
    result = presentation(kind).result
    assert result.kind == kind
    assert result.title
    assert result.__doc__
    for name, owner, field in walk(result):
        meaning = quantity_of(owner, field).meaning
        assert meaning.description, name
        assert not meaning.description.endswith("."), name
    for each in {owner for _, owner, _ in walk(result)}:
        for field, (hint, meaning) in hints(each).items():
            number = hint in (int, float, bool, complex) or hasattr(hint, "dim_str")
            assert meaning is not None or not number, f"{each.__name__}.{field}"


def test_attributes_say_which_part(make_stability: Callable[..., Stability]) -> None:
    found = to_dataset(make_stability())["blocks_m02_imag"].attrs
    assert found["units"] == "U/r0"
    assert found["long_name"].endswith("azimuthal number m = 2, imaginary part")


def test_results_compare_equal(make_stability: Callable[..., Stability]) -> None:
    result = make_stability()
    assert result == make_stability()
    assert result.base == result.base
    assert result != make_stability(growth=0.3)
    nan = replace(result.base, gap=float("nan"))
    assert nan == replace(nan)
    assert nan != result.base
    assert not equal(np.array([1.0, 2.0]), np.array([1.0, np.nan]))


@dataclass(frozen=True)
class Part:
    """With everything that a result may consist of."""

    name: str
    values: Float[np.ndarray, " any"]
    wave: Complex[np.ndarray, " any"]
    number: float | None
    words: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Named(Record):
    """Quantities by name."""

    columns: Annotated[
        dict[str, Float[np.ndarray, " step"]],
        Quantity("", "1", "a number", parts={"eps": Quantity("e", "r0", "growth")}),
    ]


def test_what_is_kept_by_a_quantitys_name_is_a_variable_with_its_meaning() -> None:
    named = Named({"eps": np.array([0.1, 0.2]), "other": np.zeros(2)})
    found = to_variables(named)
    assert set(found) == {"columns_key", "columns_eps", "columns_other"}
    assert found["columns_eps"].attributes == {"long_name": "growth", "units": "r0", "symbol": "e"}
    assert_identical(from_variables(Named, found), named)


@dataclass(frozen=True, eq=False)
class Whole(Record):
    """Parts, by name, by number, one after another, and of several kinds."""

    parts: tuple[Part, ...]
    named: dict[str, Part]
    numbered: dict[int, tuple[Part, ...]]
    either: Part | Base
    pair: tuple[float, int]
    nothing: Part | None
    flag: bool
    place: complex


def test_what_results_consist_of_survives(make_base: Callable[..., Base]) -> None:
    random = np.random.default_rng(3)

    def part(size: int, number: float | None) -> Part:
        wave = random.normal(size=size) + 1j * random.normal(size=size)
        return Part(f"p{size}", random.normal(size=size), wave, number, ("a",) * size)

    for either in (part(2, 1.0), make_base()):
        whole = Whole(
            parts=(part(3, None), part(1, -0.0), part(0, 2.5)),
            named={"two words": part(2, 1.5), "": part(2, None)},
            numbered={0: (), 7: (part(1, 1.0), part(2, 2.0))},
            either=either,
            pair=(0.1, 3),
            nothing=None,
            flag=True,
            place=complex(-0.0, float("nan")),
        )
        assert_identical(from_variables(Whole, to_variables(whole)), whole)


def test_what_has_no_form_in_files_is_refused() -> None:
    @dataclass(frozen=True)
    class Odd:
        what: set[int]

    with pytest.raises(TypeError, match=r"what: .* has no form in files"):
        to_variables(Odd({1}))


def test_file_describes_itself(make_stability: Callable[..., Stability], tmp_path: Path) -> None:
    path = save(make_stability(), tmp_path / "result.nc")
    with xr.open_dataset(path, engine="netcdf4") as data:
        assert data.attrs["kind"] == "stability"
        assert "diameter = 6.0" in str(data["base_train"].values)
        assert data.attrs["celltrain_version"]
        assert "r0" in data.attrs["units"]


def test_failure_leaves_the_older_file_and_nothing_else(
    make_base: Callable[..., Base], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = save(make_base(), tmp_path / "base.nc")
    before = path.read_bytes()

    def fail(*_: object) -> None:
        raise OSError("no space left on device")

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(OSError, match="no space"):
        save(make_base(packing=0.3), path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_missing_folder_is_an_error(make_base: Callable[..., Base], tmp_path: Path) -> None:
    with pytest.raises(OSError, match="missing"):
        save(make_base(), tmp_path / "missing" / "base.nc")
    assert list(tmp_path.iterdir()) == []


def test_foreign_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "foreign.nc"
    xr.Dataset({"x": ("y", np.arange(3))}).to_netcdf(path, engine="netcdf4")
    with pytest.raises(ValueError, match="holds no result"):
        load(path)


def test_a_damaged_file_is_refused(make_base: Callable[..., Base], tmp_path: Path) -> None:
    whole = save(make_base(), tmp_path / "base.nc").read_bytes()
    path = tmp_path / "damaged.nc"
    # The file's end is zeros, which nobody misses.
    cut = whole[: len(whole.rstrip(b"\0")) // 2]
    for content in (b"", b"no file of results", cut):
        path.write_bytes(content)
        with pytest.raises(ForeignFile, match=r"damaged\.nc' is no netCDF file, or a damaged one"):
            load(path)


def test_any_name_may_be_a_files(make_base: Callable[..., Base], tmp_path: Path) -> None:
    base = make_base()
    for name in ("Größe?x=[1].nc", os.fsdecode(b"not UTF-8 \xff.nc")):
        assert_identical(load(save(base, tmp_path / name)), base)


def test_files_of_several_threads_do_not_disturb_each_other(
    make_base: Callable[..., Base], tmp_path: Path
) -> None:
    base = make_base()
    with ThreadPoolExecutor(4) as threads:
        paths = list(threads.map(lambda n: save(base, tmp_path / f"{n}.nc"), range(16)))
        for loaded in threads.map(load, paths):
            assert_identical(loaded, base)


def test_a_file_of_another_version_says_so(
    make_stability: Callable[..., Stability], tmp_path: Path
) -> None:
    data = to_dataset(make_stability())
    data.attrs["celltrain_version"] = "0.0.9"
    path = tmp_path / "other.nc"
    data.drop_vars("convergence_degrees").to_netcdf(path, engine="netcdf4")
    with pytest.raises(OSError, match=r"celltrain 0\.0\.9 and lacks .*convergence_degrees"):
        load(path)
    for form, words in ((FORM - 1, "an older form .* computed anew"), (FORM + 1, "a newer form")):
        data.assign_attrs(form=form).to_netcdf(path, engine="netcdf4")
        with pytest.raises(OSError, match=rf"celltrain 0\.0\.9 in {words}"):
            load(path)
    data.assign_attrs(kind="riddle").to_netcdf(path, engine="netcdf4")
    with pytest.raises(ValueError, match="kind 'riddle'; known are: base, boundary"):
        load(path)
    with pytest.raises(ValueError, match="it holds no base, but: stability"):
        from_dataset(Base, data)


def test_summary_is_json_with_the_promised_keys(
    make_stability: Callable[..., Stability],
) -> None:
    result = make_stability()
    found = presentation("stability").summary(result)
    content = json.loads(json.dumps(found, allow_nan=False))
    assert set(content) >= {
        "base",
        "spectral_abscissa",
        "numerical_abscissa",
        "leading_modes",
        "seconds",
        "error_estimate",
        "convergence",
        "condition_number",
        "kind",
        "version",
    }
    assert {name for name, known in quantities(Base).items() if not known.bulky} < set(
        content["base"]
    )
    assert set(content["seconds"]) == {"compile", "base", "linearise", "spectrum", "total"}
    assert content["base"]["case"]["train"] == {"packing": 0.2, "cells": 4}
    modes = content["leading_modes"]
    assert len(modes) >= 20
    assert set(modes[0]) >= {
        "growth_rate",
        "frequency",
        "azimuthal_number",
        "wave_number",
        "neutral",
        "multiplicity",
    }
    rates = [mode["growth_rate"] for mode in modes]
    assert rates == sorted(rates, reverse=True)


def test_summary_has_null_for_what_is_not_finite(make_base: Callable[..., Base]) -> None:
    base = replace(make_base(), gap=float("nan"), residual=np.float64("inf"))
    content = json.loads(json.dumps(summary(base), allow_nan=False))
    assert content["gap"] is None
    assert content["residual"] is None
    assert "spectral_abscissa" not in content


def test_verdict_of_an_unstable_train(make_stability: Callable[..., Stability]) -> None:
    result = make_stability(growth=0.01)
    words = verdict(result)
    assert words.startswith("unstable")
    assert "over 177 r0" in words
    assert "tilts all cells alike (m = 1, q = 0)" in words


def test_only_a_stable_train_is_green() -> None:
    colors = {"marginally stable": "green", "unstable": "red", "not resolved": "red"}
    for head, color in colors.items():
        line = verdict_line(f"{head}: why")
        assert line.plain == f"{head[0].upper()}{head[1:]}: why"
        assert [str(span.style) for span in line.spans] == [f"bold {color}"]


@pytest.mark.parametrize(
    ("growth", "error", "words"),
    [
        (9e-5, 1e-6, "marginally stable"),
        (2e-4, 1e-6, "unstable"),
        (2e-4, 3e-4, "not resolved"),
        (-1e-3, 1e-6, "marginally stable"),
        (-1e-3, 5e-3, "marginally stable"),
        (9e-5, float("nan"), "marginally stable"),
        (2e-4, float("nan"), "unstable"),
    ],
)
def test_verdict_needs_growth_above_its_error(
    growth: float, error: float, words: str, make_stability: Callable[..., Stability]
) -> None:
    assert verdict(make_stability(growth=growth, error=error)).startswith(words)


@pytest.mark.parametrize("cells", [1, 2, 5])
def test_report_says_what_matters(cells: int, make_stability: Callable[..., Stability]) -> None:
    console = Console(file=StringIO(), width=120)
    show(make_stability(cells=cells), console)
    text = console.file.getvalue()  # type: ignore[attr-defined]
    for words in ("D = 6 r0", "1.77200", "Unstable", "0.01170", "0.11700", "neutral: rotation"):
        assert words in text
