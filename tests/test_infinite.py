"""Infinite trains: curves over the phase, and the most unstable wave."""

import json

import numpy as np
import pytest
import xarray as xr
from drawn import saved
from numpy.testing import assert_allclose

from celltrain import Base, CaseError, Stability, Train
from celltrain.analyses import infinite
from celltrain.cli import main
from celltrain.contract import load
from celltrain.pictures import draw_dispersion
from celltrain.results import save
from celltrain.stability import (
    InfiniteTrain,
    PaperNorm,
    block_spectrum,
    distance_to_uniform,
    infinite_train,
    linear_blocks,
    neutral_space,
    normed_blocks,
)

# All those of the N-cell train.
NUMBERS = tuple(range(7))


@pytest.fixture(scope="module")
def curves(coarse_base: Base) -> InfiniteTrain:
    return infinite_train(
        coarse_base,
        phases=np.pi * np.arange(7) / 6,
        azimuthal_numbers=NUMBERS,
        estimate_error=False,
    )


def test_a_train_of_n_cells_lies_on_the_curves(
    curves: InfiniteTrain, coarse_stability: Stability
) -> None:
    blocks = normed_blocks(coarse_stability, PaperNorm())
    assert curves.azimuthal_numbers == NUMBERS
    for m in NUMBERS:
        for j in range(2):
            # q = 2 pi j/3 are samples 0 and 4 of 0 ... pi in six steps.
            assert_allclose(curves.phases[4 * j], 2 * np.pi * j / 3, rtol=1e-15)
            modes = [
                mode
                for mode in coarse_stability.modes
                if (mode.azimuthal_number, mode.wave_number) == (m, j) and not mode.neutral
            ]
            assert_allclose(curves.growth_rates(m)[4 * j], modes[0].growth_rate, atol=1e-9)
            frequencies = [
                x.frequency for x in modes if x.growth_rate > modes[0].growth_rate - 1e-9
            ]
            assert np.abs(np.array(frequencies) - curves.frequencies(m)[4 * j]).min() < 1e-9
            eta = blocks[m, j].numerical_abscissa
            assert_allclose(curves.numerical_abscissas[m][4 * j], eta, atol=1e-9)


def test_the_optimum_is_an_eigenvalue_and_the_largest(
    curves: InfiniteTrain, coarse_base: Base
) -> None:
    best = curves.most_unstable
    samples = max(curves.growth_rates(m).max() for m in NUMBERS)
    assert best.growth_rate >= samples
    m = best.azimuthal_number
    block = linear_blocks(coarse_base, [best.phase], [m])[m][0]
    value = complex(best.growth_rate, best.frequency)
    size = np.linalg.norm(block, 2)
    assert_allclose(block @ best.right, value * best.right, atol=1e-9 * size)
    assert_allclose(best.left.conj() @ best.right, 1.0, rtol=1e-9)


def test_an_optimum_between_samples_is_found(coarse_base: Base) -> None:
    # q = 0 and its displacement are left out, so that few samples show where the maximum is.
    few = np.array([0.3, 0.9, 1.6, 2.3, 3.0])
    found = infinite_train(coarse_base, phases=few, azimuthal_numbers=NUMBERS, estimate_error=False)
    best = found.most_unstable
    m = best.azimuthal_number
    waves = np.linspace(few[0], few[-1], 10)
    blocks = linear_blocks(coarse_base, waves, NUMBERS)
    rates = {
        n: [
            next(
                value.real
                for value, kind in zip(spectrum.eigenvalues, spectrum.kinds, strict=True)
                if not kind
            )
            for spectrum in (block_spectrum(each, neutral_space(coarse_base, n, 1)) for each in b)
        ]
        for n, b in blocks.items()
    }
    largest = max(max(each) for each in rates.values())
    assert best.growth_rate >= largest - 1e-6
    assert max(rates[m]) == largest


def test_waves_go_to_uniform_disturbances(coarse_base: Base) -> None:
    distances = distance_to_uniform(coarse_base, [0.02, 0.04], NUMBERS)
    for m in (0, 1, 2):
        small, double = distances[m]
        # The difference vanishes as q does, in proportion.
        assert 0.0 < small < 1e-2
        assert_allclose(double / small, 2.0, rtol=0.05)


def test_long_waves_lose_no_digits(coarse_base: Base) -> None:
    waves = np.array([1e-5, 1e-3, 1e-2])
    distances = distance_to_uniform(coarse_base, waves.tolist(), NUMBERS)
    for m in (1, 2, 3):
        slopes = distances[m] / waves
        assert_allclose(slopes, slopes[-1], rtol=2e-3)


def test_the_degree_rises_until_the_largest_growth_rate_is_known() -> None:
    train = Train(diameter=6, packing=0.2)
    waves = [0.0, 2.0]
    found = infinite_train(train, phases=waves, azimuthal_numbers=[1])
    convergence = found.convergence
    assert found.base.train.degree == convergence.degree == convergence.degrees[-1]
    assert convergence.degrees[0] == 12
    largest = found.growth_rates(1).max()
    assert convergence.values[-1] == pytest.approx(largest, rel=1e-9)
    assert 0.0 < found.error_estimate <= 0.01 * largest
    # At a degree of its own the case stays, and is told what that leaves.
    coarse = infinite_train(train.changed(degree=8), phases=waves, azimuthal_numbers=[1])
    assert coarse.base.train.degree == 8
    change = abs(coarse.growth_rates(1).max() - largest)
    assert change <= coarse.error_estimate + found.error_estimate


def test_what_is_refused(coarse_base: Base) -> None:
    for waves, words in (
        ([0.0, 4.0], "phases = 4"),
        ([-0.1, 1.0], "phases = -0.1"),
        ([0.0, 1e-4], "phases = 0.0001"),
        ([1.0, 0.5], "do not rise"),
        ([], "none is not allowed"),
    ):
        with pytest.raises(CaseError, match=words):
            infinite_train(coarse_base, phases=waves)
    with pytest.raises(CaseError, match="azimuthal_numbers = 7"):
        infinite_train(coarse_base, azimuthal_numbers=[7])


def test_files_and_pictures(curves: InfiniteTrain, tmp_path) -> None:
    assert load(save(curves, tmp_path / "curves.nc")) == curves
    with xr.open_dataset(tmp_path / "curves.nc", engine="netcdf4") as data:
        assert_allclose(data["leading_m01_growth_rate"], curves.growth_rates(1), rtol=0)
        assert float(data["most_unstable_growth_rate"]) == curves.most_unstable.growth_rate
        assert data["leading_m01_growth_rate"].attrs["units"] == "U/r0"
    assert saved(draw_dispersion(curves), tmp_path / "curves.png").stat().st_size > 10_000


def test_command(curves, monkeypatch, tmp_path, capsys) -> None:
    asked = {}

    def compute(train, **options):
        asked.update(options)
        return curves

    monkeypatch.setattr(infinite, "infinite_train", compute)
    case = [
        "infinite",
        "--diameter",
        "6",
        "--packing",
        "0.3",
        "--degree",
        "6",
        "--quiet",
    ]
    path = tmp_path / "curves.nc"
    arguments = ["--phase", "2", "0.5", "-o", str(path), "--plot", str(tmp_path), "--json"]
    assert main([*case, *arguments]) == 0
    content = json.loads(capsys.readouterr().out)
    assert asked["phases"].tolist() == [0.5, 2.0]
    assert asked["azimuthal_numbers"] == (0, 1, 2, 3)
    assert content["most_unstable"]["growth_rate"] == curves.most_unstable.growth_rate
    assert_allclose(content["growth_rates"]["1"], curves.growth_rates(1), rtol=0)
    assert sorted(each.name for each in tmp_path.iterdir()) == ["curves.nc", "dispersion.png"]
    assert main(case) == 0
    said = capsys.readouterr().out
    assert "most unstable: growth rate" in said
    speed, rate = curves.base.cell_velocity, curves.most_unstable.growth_rate
    words = "Marginally stable: nothing grows"
    if rate > 1e-4:
        grows = f"the fastest disturbance grows e-fold over {speed / rate:.3g} r0"
        words = "Not resolved" if curves.error_estimate >= rate else f"Unstable: {grows}"
    assert words in " ".join(said.split())


def test_command_refuses(capsys) -> None:
    case = ["infinite", "--diameter", "6", "--packing", "0.2"]
    assert main([*case, "--phase", "4"]) == 2
    assert "phase = 4 is not allowed" in capsys.readouterr().err
    assert main([*case, "--degree", "12", "--azimuthal-numbers", "13"]) == 2
    assert "azimuthal_numbers = 13" in capsys.readouterr().err
    assert main([*case, "--error-bars", "2"]) == 2
    assert "--error-bars" in capsys.readouterr().err
    assert main(["stability", *case[1:], "--phase", "1"]) == 2
    assert "--phase" in capsys.readouterr().err
