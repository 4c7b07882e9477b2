"""Derivatives by the parameters of a train, against trains that are computed anew."""

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TypeVar

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
from celltrain.stability import ParameterSensitivities, linear_blocks, parameter_sensitivities
from celltrain.steady import base_sensitivities
from celltrain.train import (
    TrainOperator,
    parameter_value,
    parameters_of,
    train_operator,
    variation,
    with_parameter,
)
from celltrain.train.parameters import MODULI

T = TypeVar("T", float, complex, np.ndarray)

# Relative steps of the differences; extrapolated, their error is about the fourth power.
STEPS = (3e-3, 6e-3)
OF_THE_TRAIN = ("diameter", "packing", "bending_modulus", "capillary_number", "reduced_volume")
# The dilatation modulus follows from the other moduli and the capillary number.
EQUAL = (*OF_THE_TRAIN, "shear_modulus")
# Of a train of unequal viscosities: what each part of the derivative acts on.
UNEQUAL = ("packing", "viscosity_ratio", "reduced_volume")
M, J = 1, 1


@pytest.fixture(scope="module")
def sharp_base(coarse_base: Base) -> Base:
    """The same train, the sums so exact that differences see no change of their rules."""
    sharp = coarse_base.train.changed(tolerance=1e-9)
    return steady(sharp, start=coarse_base, estimate_error=False)


@pytest.fixture(scope="module")
def beside(sharp_base: Base) -> Callable[[str], dict[float, Base]]:
    """Trains at both sides in a parameter, by the relative step."""

    @cache
    def make(name: str) -> dict[float, Base]:
        value = parameter_value(sharp_base.train, name)
        found = {}
        for step in (*STEPS, *(-step for step in STEPS)):
            train = with_parameter(sharp_base.train, name, value * (1.0 + step))
            found[step] = steady(train, start=sharp_base, estimate_error=False)
        return found

    return make


def slope(values: dict[float, T], value: float) -> T:
    """Derivative from values at relative steps to both sides, two central differences."""
    near, far = ((values[h] - values[-h]) / (2 * h * value) for h in STEPS)
    return (4 * near - far) / 3


@pytest.mark.parametrize("name", OF_THE_TRAIN)
def test_steady_trains_change_as_differences_say(
    sharp_base: Base, beside: Callable[[str], dict[float, Base]], name: str
) -> None:
    found = base_sensitivities(sharp_base, OF_THE_TRAIN)[name]
    assert found.residual < 1e-8
    value = parameter_value(sharp_base.train, name)
    trains = beside(name)
    for quantity in ("cell_velocity", "effective_viscosity"):
        difference = slope({h: getattr(each, quantity) for h, each in trains.items()}, value)
        assert_allclose(getattr(found, quantity), difference, rtol=1e-5)
    moved = slope({h: each.coefficients for h, each in trains.items()}, value)
    size = np.abs(moved).max()
    assert_allclose(found.coefficients, moved, rtol=0, atol=1e-5 * size)


def tilt(base: Base, parameters: tuple[str, ...] | None = None) -> ParameterSensitivities:
    """Derivatives of a travelling tilt, m = 1 and j = 1."""
    result = stability(base, azimuthal_numbers=[M], estimate_error=False)
    mode = next(mode for mode in result.modes if mode.wave_number == J)
    return parameter_sensitivities(result, mode, parameters=parameters)


@pytest.fixture(scope="module")
def sensitivities(sharp_base: Base) -> ParameterSensitivities:
    """At equal viscosities, by all parameters."""
    return tilt(sharp_base)


@pytest.fixture(scope="module")
def unequal(sharp_base: Base) -> ParameterSensitivities:
    """At unequal ones; a steady train does not depend on their ratio."""
    return tilt(viscous(sharp_base, 5.0), UNEQUAL)


def viscous(base: Base, ratio: float) -> Base:
    return replace(base, train=base.train.changed(viscosity_ratio=ratio))


def eigenvalue(base: Base, near: complex) -> complex:
    """That of the tilts which is nearest to a number."""
    q = np.array([2 * np.pi * J / base.train.cells])
    block = linear_blocks(base.train, base.coefficients, q, [M])[M][0]
    values = np.linalg.eigvals(block)
    return complex(values[np.abs(values - near).argmin()])


@pytest.mark.parametrize(
    ("found", "name"),
    [("sensitivities", name) for name in EQUAL] + [("unequal", name) for name in UNEQUAL],
)
def test_eigenvalues_change_as_differences_say(
    found: str,
    name: str,
    beside: Callable[[str], dict[float, Base]],
    request: pytest.FixtureRequest,
) -> None:
    known: ParameterSensitivities = request.getfixturevalue(found)
    entry, base = known.entries[name], known.base
    ratio = base.train.flow.viscosity_ratio
    value = complex(known.mode.growth_rate, known.mode.frequency)
    exact = complex(entry.growth_rate, entry.frequency)
    if name == "viscosity_ratio":
        trains = {h: viscous(base, ratio * (1 + h)) for s in STEPS for h in (s, -s)}
    else:
        trains = {h: viscous(each, ratio) for h, each in beside(name).items()}
    values = {h: eigenvalue(each, value) for h, each in trains.items()}
    assert abs(slope(values, entry.value) - exact) < 1e-5 * abs(exact)
    assert entry.value == parameter_value(base.train, name)
    assert entry.relative == entry.value * entry.growth_rate


def test_a_sphere_has_no_reduced_volume(make_base: Callable[..., Base]) -> None:
    sphere = make_base(reference="sphere")
    assert "reduced_volume" not in parameters_of(sphere.train)
    with pytest.raises(CaseError, match="parameter = 'reduced_volume' is not allowed"):
        base_sensitivities(sphere, ["reduced_volume"])
    # Nor is there a derivative where a cell becomes one.
    with pytest.raises(CaseError, match=r"reduced_volume = 1 is not allowed.*allowed: < 1"):
        base_sensitivities(make_base(reduced_volume=1.0), ["reduced_volume"])


def test_the_flow_acts_on_all_moduli(
    sharp_base: Base, sensitivities: ParameterSensitivities
) -> None:
    # Twice the flow is half of all moduli, and the derivatives are of one function.
    train = with_parameter(
        sharp_base.train, "capillary_number", 2.0 * sharp_base.train.cell.capillary_number
    )
    for name in MODULI:
        assert_allclose(train.leaf(name), 0.5 * sharp_base.train.leaf(name), rtol=1e-14)
    entries = sensitivities.entries
    by_moduli = -sum(entries[name].relative for name in MODULI)
    assert_allclose(entries["capillary_number"].relative, by_moduli, rtol=1e-9)
    with pytest.raises(CaseError, match="capillary_number = -1"):
        with_parameter(train, "capillary_number", -1.0)


def test_operators_vary_as_they_are_made_anew(sharp_base: Base) -> None:
    # To second order in the change, at the same rules.
    train = sharp_base.train
    shapes = jnp.asarray(sharp_base.coefficients)[None]
    names = ("diameter", "packing", "dilatation_modulus", "reduced_volume")
    varied = variation(train_operator(train, meridian=True), train, names)

    def rates(operator: TrainOperator) -> np.ndarray:
        return np.asarray(eqx.filter_jit(TrainOperator.rates)(operator, shapes))

    for name in names:
        start = varied.start[name]
        assert_allclose(rates(varied.at({name: start})), rates(varied.operator), atol=1e-14)
        errors = []
        # The resting shape bends most with its parameter.
        for step in (2e-4, 1e-4) if name == "reduced_volume" else (2e-3, 1e-3):
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

    def compute(result: Stability, mode: Mode, *, parameters: Sequence[str] | None) -> object:
        asked.append((mode, parameters))
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
    assert asked == [(modes[1], ["packing", "diameter"])]
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
