"""How accurate growth rates are: degrees that rise, errors that are stated, double eigenvalues."""

import json
import math
from io import StringIO

import pytest
from rich.console import Console

from celltrain import CaseError, Stability, Train, load, save, show, stability
from celltrain.cli import main
from celltrain.contract import presentation
from celltrain.stability import NEAR_DOUBLE, check_accuracy, leading_condition
from celltrain.stability.convergence import AbscissaLadder

CASE = ["--diameter", "6", "--packing", "0.2", "--cells", "1", "--azimuthal-numbers", "0", "1"]
NUMBERS = (0, 1, 2, 3)


def printed(result: Stability) -> str:
    """A result's report in one line."""
    console = Console(file=StringIO(), width=200)
    show(result, console)
    return " ".join(console.file.getvalue().split())  # type: ignore[attr-defined]


@pytest.fixture(scope="module")
def left_open() -> Stability:
    """Of a train without a degree."""
    train = Train(diameter=6, packing=0.2, cells=1)
    return stability(train, azimuthal_numbers=(0, 1))


def test_a_train_without_a_degree_gets_one(left_open: Stability) -> None:
    found = left_open.convergence
    assert left_open.base.train.degree == found.degree == found.degrees[-1]
    assert found.values[-1] == pytest.approx(left_open.spectral_abscissa, rel=1e-9)
    assert 0.0 < left_open.error_estimate <= 0.01 * left_open.spectral_abscissa
    finer = AbscissaLadder(left_open.base, (0, 1)).abscissa(32)
    change = abs(finer - left_open.spectral_abscissa)
    assert change <= left_open.error_estimate


def test_the_report_says_what_each_degree_gives(left_open: Stability) -> None:
    text = printed(left_open)
    degree = left_open.base.train.degree
    assert f"M = {degree}" in text
    assert f"degree {degree}; alpha at each degree: " in text
    for each, rate in zip(left_open.convergence.degrees, left_open.convergence.values, strict=True):
        assert f"{rate:.5f} ({each})" in text
    content = presentation("stability").summary(left_open)
    convergence = content["convergence"]
    assert isinstance(convergence, dict)
    assert convergence["degree"] == degree
    assert convergence["degrees"] == list(left_open.convergence.degrees)
    assert convergence["values"] == list(left_open.convergence.values)
    assert content["error_estimate"] == left_open.error_estimate
    assert content["condition_number"] == leading_condition(left_open)


def test_the_file_keeps_how_the_degree_was_found(left_open: Stability, tmp_path) -> None:
    again = load(save(left_open, tmp_path / "result.nc"))
    assert isinstance(again, Stability)
    assert again.convergence == left_open.convergence
    assert again.error_estimate == left_open.error_estimate


def test_the_accuracy_is_an_option_of_the_command(capsys) -> None:
    found = {}
    for accuracy in ("0.1", "0.01"):
        assert main(["stability", *CASE, "--accuracy", accuracy, "--json", "--quiet"]) == 0
        found[accuracy] = json.loads(capsys.readouterr().out)
    low, high = found["0.1"], found["0.01"]
    assert low["convergence"]["degree"] < high["convergence"]["degree"]
    assert low["convergence"]["degrees"] == high["convergence"]["degrees"][:-1]
    for accuracy, each in found.items():
        assert each["error_estimate"] <= float(accuracy) * each["spectral_abscissa"]
        degree = each["base"]["case"]["resolution"]["degree"]
        assert degree == each["convergence"]["degree"]
        assert each["condition_number"] >= 1.0
    assert main(["stability", *CASE, "--accuracy", "0.1", "--quiet"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert f"degree {low['convergence']['degree']}; alpha at each degree: " in text


@pytest.mark.parametrize("accuracy", ["0", "-1", "2", "nan"])
def test_accuracies_that_are_not_allowed(accuracy: str, capsys) -> None:
    with pytest.raises(CaseError, match="1e-06 to 1"):
        check_accuracy(float(accuracy))
    for command in ("stability", "transient"):
        assert main([command, *CASE, "--accuracy", accuracy]) == 2
        message = capsys.readouterr().err
        assert f"accuracy = {float(accuracy):g} is not allowed" in message
        assert "1e-06 to 1" in message
    assert main(["stability", *CASE, "--accuracy", "high"]) == 2
    assert "high" in capsys.readouterr().err


@pytest.mark.parametrize(("diameter", "packing"), [(6, 0.2), (7, 0.4)])
def test_the_error_at_a_given_degree_is_told(diameter: float, packing: float) -> None:
    train = Train(diameter=diameter, packing=packing, degree=12)
    result = stability(train, azimuthal_numbers=NUMBERS)
    assert result.base.train == train
    assert result.convergence.degree == 12
    finer = AbscissaLadder(result.base, NUMBERS).abscissa(32)
    change = abs(finer - result.spectral_abscissa)
    assert change <= result.error_estimate
    # And not much more than that.
    assert result.error_estimate < 1.5 * change
    without = stability(result.base, azimuthal_numbers=[1], estimate_error=False)
    assert math.isnan(without.error_estimate)
    assert without.convergence.degrees == ()
    assert "alpha at each degree" not in printed(without)


def test_closeness_to_a_double_eigenvalue_is_told(left_open: Stability) -> None:
    train = Train(diameter=8, packing=0.2, cells=1, degree=24)
    # A flow 2.8/0.66 times as strong.
    train = train.changed(capillary_number=2.8 / 0.66 * train.leaf("capillary_number"))
    result = stability(train, azimuthal_numbers=(0, 1), estimate_error=False)
    assert leading_condition(result) > NEAR_DOUBLE
    first, second = [mode for mode in result.modes if not mode.neutral][:2]
    assert (first.azimuthal_number, second.azimuthal_number) == (1, 1)
    assert abs(first.growth_rate - second.growth_rate) < 2e-3
    words = f"close to a double eigenvalue (condition number {leading_condition(result):.0f})"
    assert words in printed(result)
    assert leading_condition(left_open) < NEAR_DOUBLE
    assert "double eigenvalue" not in printed(left_open)
