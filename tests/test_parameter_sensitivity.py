"""Derivatives by the parameters of a train, against trains that are computed anew."""

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TypeVar

import numpy as np
import pytest
import scipy.linalg
from drawn import saved
from numpy.testing import assert_allclose

from celltrain import Base, CaseError, Mode, Stability, Train, save
from celltrain.analyses import sensitivity as command
from celltrain.cli import main
from celltrain.contract import analysis, load
from celltrain.harmonics import coefficients_of
from celltrain.meridian.rules import Rules
from celltrain.parameters.strength import MODULI
from celltrain.pictures import draw_parameter_sensitivities
from celltrain.stability import (
    ParameterSensitivities,
    WaveMode,
    linear_blocks,
    parameter_sensitivities,
    wave_sensitivities,
)
from celltrain.steady import base_sensitivities
from celltrain.steady import varied as varied_module
from celltrain.steady.iterate import newton
from celltrain.steady.parameters import parameter_value, parameters_of
from celltrain.steady.problem import SteadyProblem
from celltrain.steady.varied import SHARP, VariedTrain

T = TypeVar("T", float, complex, np.ndarray)

# Relative steps of the differences; extrapolated, their error is of fourth order.
STEPS = (5e-4, 1e-3)
OF_THE_TRAIN = (
    "diameter",
    "packing",
    "shear_modulus",
    "bending_modulus",
    "capillary_number",
    "reduced_volume",
)
# Of a train of unequal viscosities: what each part of the derivative acts on.
UNEQUAL = ("diameter", "packing", "viscosity_ratio", "reduced_volume")
M, J = 1, 1


class Held(SteadyProblem):
    """The steady equations of a train with given rules."""

    def __init__(self, train: Train, rules: Rules) -> None:
        super().__init__(train)
        self._held = rules

    def rules(self, profile: np.ndarray) -> Rules:
        return self._held


def converged(base: Base, train: Train, rules: Rules) -> Base:
    """The steady train beside a known one."""
    found = newton(Held(train, rules), base.profile, tolerance=1e-12, most=12)
    assert found.steady
    return replace(
        base,
        train=train,
        coefficients=coefficients_of(found.state.profile),
        cell_velocity=found.state.cell_velocity,
        effective_viscosity=found.state.flow.effective_viscosity,
    )


@pytest.fixture(scope="module")
def rules(coarse_base: Base) -> Rules:
    """Those of the train, with sums so exact that differences do not see how long they are."""
    return replace(SteadyProblem(coarse_base.train).rules(coarse_base.profile), tolerance=SHARP)


@pytest.fixture(scope="module")
def sharp_base(coarse_base: Base, rules: Rules) -> Base:
    """The same train, converged with these rules."""
    return converged(coarse_base, coarse_base.train, rules)


@pytest.fixture(scope="module")
def beside(sharp_base: Base, rules: Rules) -> Callable[[str], dict[float, Base]]:
    """Trains at both sides in a parameter, by the relative step."""

    @cache
    def make(name: str) -> dict[float, Base]:
        value = parameter_value(sharp_base.train, name)
        return {
            step: converged(
                sharp_base, sharp_base.train.changed(**{name: value * (1.0 + step)}), rules
            )
            for size in STEPS
            for step in (size, -size)
        }

    return make


def slope(values: dict[float, T], value: float) -> T:
    """Derivative from values at relative steps to both sides, two central differences."""
    near, far = ((values[h] - values[-h]) / (2 * h * value) for h in STEPS)
    return (4 * near - far) / 3


@pytest.mark.parametrize("name", OF_THE_TRAIN)
def test_steady_trains_change_as_differences_say(
    sharp_base: Base, beside: Callable[[str], dict[float, Base]], name: str
) -> None:
    found = base_sensitivities(sharp_base, [name])[name]
    assert found.residual < 1e-8
    value = parameter_value(sharp_base.train, name)
    trains = beside(name)
    for quantity in ("cell_velocity", "effective_viscosity"):
        difference = slope({h: getattr(each, quantity) for h, each in trains.items()}, value)
        assert_allclose(getattr(found, quantity), difference, rtol=1e-8)
    moved = slope({h: each.coefficients for h, each in trains.items()}, value)
    size = np.abs(moved).max()
    assert_allclose(found.coefficients, moved, rtol=0, atol=1e-8 * size)


def tilt(base: Base, rules: Rules, near: complex | None = None) -> WaveMode:
    """The leading travelling tilt, m = 1 and j = 1, or that nearest to a number."""
    q = 2.0 * np.pi * J / base.train.cells
    block = linear_blocks(base, [q], [M], rules=rules)[M][0]
    values, left, right = scipy.linalg.eig(block, left=True, right=True)
    i = int(values.real.argmax() if near is None else np.abs(values - near).argmin())
    adjoint = left[:, i] / (left[:, i].conj() @ right[:, i]).conj()
    return WaveMode(values[i].real, values[i].imag, M, q, right[:, i], adjoint)


@pytest.fixture(scope="module")
def sensitivities(sharp_base: Base, rules: Rules) -> ParameterSensitivities:
    """At equal viscosities, by all parameters."""
    return wave_sensitivities(sharp_base, tilt(sharp_base, rules))


@pytest.fixture(scope="module")
def unequal(sharp_base: Base, rules: Rules) -> ParameterSensitivities:
    """At unequal ones; a steady train does not depend on their ratio."""
    base = viscous(sharp_base, 5.0)
    return wave_sensitivities(base, tilt(base, rules), parameters=UNEQUAL)


def viscous(base: Base, ratio: float) -> Base:
    return replace(base, train=base.train.changed(viscosity_ratio=ratio))


@pytest.mark.parametrize(
    ("found", "name"),
    [("sensitivities", name) for name in OF_THE_TRAIN] + [("unequal", name) for name in UNEQUAL],
)
def test_eigenvalues_change_as_differences_say(
    found: str,
    name: str,
    beside: Callable[[str], dict[float, Base]],
    rules: Rules,
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
    modes = {h: tilt(each, rules, value) for h, each in trains.items()}
    values = {h: complex(each.growth_rate, each.frequency) for h, each in modes.items()}
    assert abs(slope(values, entry.value) - exact) < 1e-7 * abs(exact)
    assert entry.value == parameter_value(base.train, name)
    assert entry.relative == entry.value * entry.growth_rate


def test_derivatives_hardly_depend_on_the_step(
    sharp_base: Base, sensitivities: ParameterSensitivities, monkeypatch: pytest.MonkeyPatch
) -> None:
    known = sensitivities.entries["diameter"]
    for factor in (0.5, 2.0):
        monkeypatch.setattr(varied_module, "STEP", factor * varied_module.STEP)
        again = wave_sensitivities(sharp_base, sensitivities.mode, parameters=["diameter"])
        entry = again.entries["diameter"]
        assert_allclose(entry.growth_rate, known.growth_rate, rtol=1e-9)
        assert_allclose(entry.base.cell_velocity, known.base.cell_velocity, rtol=1e-9)
        monkeypatch.undo()


def test_modes_of_a_train_are_waves(coarse_stability: Stability) -> None:
    mode = next(each for each in coarse_stability.modes if not each.neutral and each.wave_number)
    found = parameter_sensitivities(coarse_stability, mode, parameters=["packing"])
    assert found.mode.phase == 2.0 * np.pi * mode.wave_number / coarse_stability.base.train.cells
    wave = found.mode
    again = wave_sensitivities(coarse_stability.base, wave, parameters=["packing"])
    assert again.entries["packing"].growth_rate == found.entries["packing"].growth_rate


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
    train = sharp_base.train.changed(capillary_number=2.0 * sharp_base.train.cell.capillary_number)
    for name in MODULI:
        assert_allclose(train.leaf(name), 0.5 * sharp_base.train.leaf(name), rtol=1e-14)
    entries = sensitivities.entries
    by_moduli = -sum(entries[name].relative for name in MODULI)
    assert_allclose(entries["capillary_number"].relative, by_moduli, rtol=1e-9)
    with pytest.raises(CaseError, match="capillary_number = -1"):
        train.changed(capillary_number=-1.0)


@pytest.mark.parametrize("name", [*OF_THE_TRAIN, "dilatation_modulus"])
def test_trains_vary_as_they_are_made_anew(sharp_base: Base, name: str) -> None:
    problem, profile = SteadyProblem(sharp_base.train), sharp_base.profile
    varied = VariedTrain(problem, profile, name)
    change = 2e-4 * varied.value
    anew = SteadyProblem(sharp_base.train.changed(**{name: varied.value + change}))
    rates = anew.flow(profile, varied.rules).rates
    found = varied.flow(change, profile).rates
    moved = np.abs(found - varied.flow(0.0, profile).rates).max()
    # Shapes at rest are taken to first order.
    allowed = 1e-2 * moved if name == "reduced_volume" else 1e-12
    assert_allclose(found, rates, rtol=0, atol=allowed)
    assert moved > 1e-7
    assert_allclose(varied.volume(change), anew.target_volume, rtol=1e-5)


def test_what_is_refused(coarse_base: Base, coarse_stability: Stability) -> None:
    with pytest.raises(CaseError, match=r"parameter = 'degree' .*allowed: diameter, packing"):
        base_sensitivities(coarse_base, ["degree"])
    with pytest.raises(CaseError, match="parameter = 'cells'"):
        parameter_sensitivities(coarse_stability, parameters=["cells"])
    neutral = next(mode for mode in coarse_stability.modes if mode.neutral)
    with pytest.raises(CaseError, match=f"mode = {neutral.neutral_kind} is not allowed"):
        parameter_sensitivities(coarse_stability, neutral)


def test_picture(sensitivities: ParameterSensitivities, tmp_path: Path) -> None:
    path = saved(draw_parameter_sensitivities(sensitivities), tmp_path / "bars.png")
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

    monkeypatch.setattr(analysis, "stability", lambda train, **_: coarse_stability)
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
    entries = content["parameters"]["entries"]
    assert entries["packing"]["growth_rate"] == by_packing.growth_rate
    assert content["condition_number"] >= 1.0
    again = load(path)
    assert isinstance(again, command.Sensitivity)
    assert again.parameters == sensitivities
    assert again.condition_number == content["condition_number"]
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
