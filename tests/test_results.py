import json
import os
from collections.abc import Callable
from dataclasses import fields, is_dataclass, replace
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from rich.console import Console

from celltrain.results import (
    QUANTITIES,
    attributes,
    dataset,
    load,
    print_registry,
    print_report,
    quantity,
    save,
    summary,
    verdict,
)
from celltrain.stability import Stability
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


def test_every_variable_has_an_entry_in_the_registry(
    make_stability: Callable[..., Stability], tmp_path: Path
) -> None:
    path = save(make_stability(), tmp_path / "result.nc")
    seen = set()
    with xr.open_dataset(path, engine="h5netcdf") as data:
        for name, variable in data.variables.items():
            entry = quantity(str(name))
            seen.add(entry.name)
            assert variable.attrs["units"] == entry.unit
            assert variable.attrs["long_name"].startswith(entry.description)
            assert len(variable.dims) == len(entry.dims)
    assert seen == set(QUANTITIES), "the registry lists what no file holds"


def test_every_field_of_a_result_is_written(make_stability: Callable[..., Stability]) -> None:
    result = make_stability()
    written = {quantity(str(name)).name for name in dataset(result).variables}
    in_attributes = {"train", "origin"}
    renamed = {"seconds": "base_seconds", "history": "history_step"}
    for field in fields(Base):
        if field.name not in in_attributes:
            assert renamed.get(field.name, field.name) in written
    renamed = {
        "modes": "mode_growth_rate",
        "transient": "transient_vector",
        "error_bars": "bar_mode",
        "convergence": "convergence_abscissas",
    }
    for field in fields(Stability):
        if field.name != "base":
            assert renamed.get(field.name, field.name) in written


@pytest.mark.parametrize(
    "name", ["nonsense", "blocks", "gap_real", "blocks_m00", "coefficients_m01"]
)
def test_unknown_variables_are_refused(name: str) -> None:
    if name == "blocks":
        assert quantity(name).is_complex
    else:
        with pytest.raises(KeyError, match=name):
            quantity(name)


def test_attributes_say_which_part() -> None:
    found = attributes("blocks_m03_imag")
    assert found["units"] == "U/r0"
    assert found["long_name"].endswith("azimuthal number m = 3, imaginary part")


def test_file_describes_itself(make_stability: Callable[..., Stability], tmp_path: Path) -> None:
    path = save(make_stability(), tmp_path / "result.nc")
    with xr.open_dataset(path, engine="h5netcdf") as data:
        assert data.attrs["kind"] == "stability"
        assert "diameter = 6.0" in data.attrs["case"]
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
    xr.Dataset({"x": ("y", np.arange(3))}).to_netcdf(path, engine="h5netcdf")
    with pytest.raises(ValueError, match="holds no result"):
        load(path)


def test_a_file_of_an_older_version_says_what_it_lacks(
    make_stability: Callable[..., Stability], tmp_path: Path
) -> None:
    data = dataset(make_stability()).drop_vars("convergence_degrees")
    data.attrs["celltrain_version"] = "0.0.9"
    data.to_netcdf(tmp_path / "old.nc", engine="h5netcdf")
    with pytest.raises(OSError, match=r"celltrain 0\.0\.9 and lacks .*convergence_degrees"):
        load(tmp_path / "old.nc")


def test_summary_is_json_with_the_promised_keys(
    make_stability: Callable[..., Stability],
) -> None:
    result = make_stability()
    content = json.loads(json.dumps(summary(result), allow_nan=False))
    assert set(content) >= {
        "cell_velocity",
        "gap",
        "largest_radius",
        "effective_viscosity",
        "residual",
        "spectral_abscissa",
        "numerical_abscissa",
        "leading_modes",
        "seconds",
        "error_estimate",
        "degree",
        "convergence",
        "condition_number",
        "case",
        "version",
    }
    assert set(content["seconds"]) == {"compile", "base", "linearise", "spectrum", "total"}
    assert content["case"]["train"] == {"packing": 0.2, "cells": 4}
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


def test_summary_has_null_for_what_is_no_number(make_base: Callable[..., Base]) -> None:
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
    print_report(make_stability(cells=cells), console)
    text = console.file.getvalue()  # type: ignore[attr-defined]
    for words in ("D = 6 r0", "1.77200", "Unstable", "0.01170", "0.11700", "neutral: rotation"):
        assert words in text


def test_registry_prints_every_quantity() -> None:
    console = Console(file=StringIO(), width=200)
    print_registry(console)
    text = console.file.getvalue()  # type: ignore[attr-defined]
    assert all(name in text for name in QUANTITIES)
