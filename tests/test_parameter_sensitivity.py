"""Derivatives by the parameters of a train, against trains that are computed anew."""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose

from celltrain import Base, CaseError, Mode, Stability, save, stability, steady
from celltrain.cli import analyses, main
from celltrain.cli import sensitivity as command
from celltrain.pictures import draw_parameter_sensitivities
from celltrain.stability import (
    ParameterSensitivities,
    block_spectrum,
    linear_blocks,
    neutral_space,
    parameter_sensitivities,
)
from celltrain.steady import base_sensitivities
from celltrain.train import PARAMETERS, TrainOperator, train_operator, variation

# Relative step of the differences, whose error is about its square.
STEP = 3e-3


@pytest.fixture(scope="module")
def sharp_base(coarse_base: Base) -> Base:
    """The same train, the sums so exact that differences see no change of their rules."""
    sharp = coarse_base.train.changed(tolerance=1e-9)
    return steady(sharp, start=coarse_base, estimate_error=False)


def mode_of(base: Base, m: int, j: int) -> tuple[complex, np.ndarray, np.ndarray]:
    """The leading eigenvalue of a block with its left and right vector."""
    q = np.array([2 * np.pi * j / base.train.cells])
    block = linear_blocks(base.train, base.coefficients, q, [m])[m][0]
    spectrum = block_spectrum(block, neutral_space(base, m, j))
    index = spectrum.kinds.index("")
    return spectrum.eigenvalues[index], spectrum.left[:, index], spectrum.right[:, index]


def neighbours(base: Base, name: str) -> tuple[float, list[Base]]:
    """The step, and the trains at both sides of it."""
    value = base.train.leaf(name)
    step = STEP * value
    trains = (base.train.changed(**{name: value + s}) for s in (-step, step))
    return step, [steady(train, start=base, estimate_error=False) for train in trains]


@pytest.mark.parametrize("name", ["diameter", "packing", "shear_modulus", "bending_modulus"])
def test_steady_trains_change_as_differences_say(sharp_base: Base, name: str) -> None:
    found = base_sensitivities(sharp_base)[name]
    assert found.residual < 1e-8
    step, (below, above) = neighbours(sharp_base, name)
    for quantity in ("cell_velocity", "effective_viscosity"):
        difference = (getattr(above, quantity) - getattr(below, quantity)) / (2 * step)
        assert_allclose(getattr(found, quantity), difference, rtol=1e-4)
    moved = (above.coefficients - below.coefficients) / (2 * step)
    size = np.abs(moved).max()
    assert_allclose(found.coefficients, moved, rtol=0, atol=1e-4 * size)


@pytest.fixture(scope="module", params=[1.0, 5.0])
def sensitivities(request: pytest.FixtureRequest, sharp_base: Base) -> ParameterSensitivities:
    """Of a travelling tilt, m = 1 and j = 1, at equal and unequal viscosities."""
    # A steady train does not depend on the viscosity ratio.
    train = sharp_base.train.changed(viscosity_ratio=request.param)
    result = stability(
        replace(sharp_base, train=train), azimuthal_numbers=[1], estimate_error=False
    )
    mode = next(mode for mode in result.modes if mode.wave_number == 1)
    return parameter_sensitivities(result, mode)


@pytest.mark.parametrize("name", PARAMETERS)
def test_eigenvalues_change_as_differences_say(
    sensitivities: ParameterSensitivities, name: str
) -> None:
    base = sensitivities.base
    entry = sensitivities.entries[name]
    value = complex(sensitivities.mode.growth_rate, sensitivities.mode.frequency)
    exact = complex(entry.growth_rate, entry.frequency)
    step, trains = neighbours(base, name)
    below, above = (mode_of(each, 1, 1)[0] for each in trains)
    assert_allclose((above + below) / 2, value, rtol=1e-3)
    assert abs((above - below) / (2 * step) - exact) < 1e-4 * abs(exact)
    assert entry.value == base.train.leaf(name)
    assert entry.relative == entry.value * entry.growth_rate


def test_operators_vary_as_they_are_made_anew(sharp_base: Base) -> None:
    # To second order in the change, at the same rules.
    train = sharp_base.train
    shapes = jnp.asarray(sharp_base.coefficients)[None]
    varied = variation(train_operator(train, meridian=True), train)

    def rates(operator: TrainOperator) -> np.ndarray:
        return np.asarray(eqx.filter_jit(TrainOperator.rates)(operator, shapes))

    for name in ("diameter", "packing", "dilatation_modulus"):
        start = varied.start[name]
        assert_allclose(rates(varied.at({name: start})), rates(varied.operator), atol=1e-14)
        errors = []
        for step in (2e-3, 1e-3):
            changed = train.changed(**{name: float(start * (1 + step))})
            anew = train_operator(changed, meridian=True)
            assert anew.tube.wall.response.shape == varied.operator.tube.wall.response.shape
            errors.append(np.abs(rates(anew) - rates(varied.at({name: start * (1 + step)}))).max())
        change = np.abs(rates(anew) - rates(varied.operator)).max()
        assert change > 1e-5
        assert errors[1] < 1e-2 * change
        assert errors[1] < 1e-12 or errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)


def test_what_is_refused(coarse_base: Base, coarse_stability: Stability) -> None:
    with pytest.raises(CaseError, match=r"parameter = 'degree' .*allowed: diameter, packing"):
        base_sensitivities(coarse_base, ["degree"])
    with pytest.raises(CaseError, match="parameter = 'cells'"):
        parameter_sensitivities(coarse_stability, parameters=["cells"])
    neutral = next(mode for mode in coarse_stability.modes if mode.neutral)
    with pytest.raises(CaseError, match=f"mode = {neutral.neutral_kind} is not allowed"):
        parameter_sensitivities(coarse_stability, neutral)


def test_picture(sensitivities: ParameterSensitivities, tmp_path: Path) -> None:
    path = draw_parameter_sensitivities(sensitivities, tmp_path / "bars.png")
    assert path.stat().st_size > 10_000


def test_command(
    coarse_stability: Stability,
    sensitivities: ParameterSensitivities,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    asked = []

    def compute(result: Stability, mode: Mode, *, parameters: Sequence[str]) -> object:
        asked.append((mode, tuple(parameters)))
        return sensitivities

    monkeypatch.setattr(analyses, "steady", lambda train, **_: coarse_stability.base)
    monkeypatch.setattr(command, "stability", lambda base, **_: coarse_stability)
    monkeypatch.setattr(command, "parameter_sensitivities", compute)
    path = tmp_path / "found.nc"
    result = save(coarse_stability.base, tmp_path / "train.nc")
    options = ["--mode", "2", "--parameter", "packing", "diameter", "--json", "--quiet"]
    files = ["-o", str(path), "--plot", str(tmp_path / "pictures")]
    assert main(["sensitivity", str(result), *options, *files]) == 0
    content = json.loads(capsys.readouterr().out)
    modes = [mode for mode in coarse_stability.modes if not mode.neutral]
    assert asked == [(modes[1], ("packing", "diameter"))]
    by_packing = sensitivities.entries["packing"]
    assert content["parameters"]["packing"]["growth_rate"] == by_packing.growth_rate
    assert content["condition_number"] >= 1.0
    with xr.open_dataset(path, engine="h5netcdf") as data:
        assert float(data["growth_rate"].sel(parameter="packing")) == by_packing.growth_rate
        assert data["sensitivity"].dims == ("theta",)
        assert "[tube]" in data.attrs["case"]
    drawn = sorted(each.name for each in (tmp_path / "pictures").iterdir())
    assert drawn == ["parameter_sensitivities.png", "structural_sensitivity.png"]
    assert main(["sensitivity", str(result), "--quiet"]) == 0
    assert "d alpha/dp" in capsys.readouterr().out


def test_command_refuses(capsys: pytest.CaptureFixture[str]) -> None:
    case = ["sensitivity", "--diameter", "6", "--packing", "0.2"]
    assert main([*case, "--parameter", "cells"]) == 2
    assert "parameter = 'cells' is not allowed" in capsys.readouterr().err
    assert main([*case, "--mode", "0"]) == 2
    assert "mode = 0 is not allowed" in capsys.readouterr().err
