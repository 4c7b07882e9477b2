"""Error bars of growth rates: what they are made of, what they allow to be said, where they go."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from drawn import saved
from numpy.testing import assert_allclose
from rich.console import Console

from celltrain import (
    CaseError,
    Stability,
    Train,
    load,
    save,
    show,
    stability,
    steady,
    summary,
)
from celltrain.cli import main
from celltrain.pictures import draw_error_bars
from celltrain.stability import ErrorBar, block_spectrum, with_error_bars
from celltrain.stability.error_bars import LEAST_OVERLAP, _paired
from celltrain.stability.neutral import NeutralSpace
from celltrain.stability.verdict import verdict
from celltrain.steady.solve import at_degree


def test_modes_are_recognised_by_their_vectors(coarse_stability: Stability) -> None:
    # Of 0.1 and 0.05, whose order changes; the nearest ones would be the wrong ones.
    random = np.random.default_rng(7)
    vectors = np.eye(6) + 0.2 * random.normal(size=(6, 6))
    swapped = np.array([0.06, 0.09, -1.0, -2.0, -3.0, -4.0])
    nothing = NeutralSpace(np.zeros((6, 0)), (), None)
    block = (vectors * swapped) @ np.linalg.inv(vectors)
    spectrum = block_spectrum(block.astype(complex), nothing)
    modes = [mode for mode in coarse_stability.modes if not mode.neutral][:2]
    units = (vectors / np.linalg.norm(vectors, axis=0)).astype(complex)
    columns = [units[:, 0], units[:, 1]]
    found = _paired(modes, columns, spectrum)
    assert_allclose([found[mode][0] for mode in modes], [0.06, 0.09], rtol=1e-10)
    assert_allclose([found[mode][1] for mode in modes], 1.0, rtol=1e-10)
    # A vector that belongs to no single mode is not recognised.
    assert _paired(modes[:1], [units.sum(axis=1) / 3.0], spectrum) == {}


@pytest.fixture(scope="module")
def barred(coarse_stability: Stability) -> Stability:
    return with_error_bars(coarse_stability, count=3)


def test_bars_are_changes_of_the_eigenvalues(
    barred: Stability, coarse_stability: Stability
) -> None:
    modes = [mode for mode in coarse_stability.modes if not mode.neutral][:3]
    assert [bar.mode for bar in barred.error_bars] == modes
    base = coarse_stability.base
    numbers = sorted({mode.azimuthal_number for mode in modes})

    # From degree 6 to the first two of the ladder.
    again = [
        stability(at_degree(base, degree), azimuthal_numbers=numbers, estimate_error=False)
        for degree in (12, 16)
    ]
    for bar in barred.error_bars:
        value = complex(bar.mode.growth_rate, bar.mode.frequency)
        near, far = (
            each.eigenvalues[bar.mode.azimuthal_number][bar.mode.wave_number] for each in again
        )
        changes = np.abs(far - value) + np.abs(far - near[:, None])
        assert np.abs(changes - bar.by_degree).min() < 1e-9
        assert bar.by_degree > 0.0
        assert bar.by_rules < bar.by_degree
        assert LEAST_OVERLAP < bar.overlap < 1.5
        assert bar.total == bar.by_degree + bar.by_rules
    assert barred.spectral_abscissa == coarse_stability.spectral_abscissa
    assert barred.seconds["error_bars"] > 0.0


def test_bars_cover_what_higher_degrees_find() -> None:
    base = steady(Train(diameter=6, packing=0.2, cells=1, degree=12), estimate_error=False)
    found = with_error_bars(
        stability(base, azimuthal_numbers=(0, 1), estimate_error=False), count=2
    )
    finer = stability(at_degree(base, 24), azimuthal_numbers=(0, 1), estimate_error=False)
    for bar in found.error_bars:
        assert bar.by_rules < 0.1 * bar.by_degree
        m, value = bar.mode.azimuthal_number, complex(bar.mode.growth_rate, bar.mode.frequency)
        assert np.abs(finer.eigenvalues[m][0] - value).min() <= bar.total


def with_bars(result: Stability, sizes: list[float]) -> Stability:
    modes = [mode for mode in result.modes if not mode.neutral]
    bars = tuple(ErrorBar(mode, size, 0.0, 1.0) for mode, size in zip(modes, sizes, strict=False))
    return replace(result, error_bars=bars)


def test_a_sign_is_stated_only_where_the_bars_allow_it(coarse_stability: Stability) -> None:
    assert coarse_stability.growth_sign is None
    rate = coarse_stability.leading.growth_rate
    assert rate < 0.0
    known = with_bars(coarse_stability, [0.9 * abs(rate)] * 2)
    assert known.growth_sign == -1
    assert "it is negative" in verdict(known)
    open_ = with_bars(coarse_stability, [0.9 * abs(rate), 100.0])
    assert open_.growth_sign == 0
    assert "leave its sign open" in verdict(open_)
    assert with_bars(coarse_stability, [float("nan")]).growth_sign == 0
    bars = tuple(
        replace(bar, mode=replace(bar.mode, growth_rate=-bar.mode.growth_rate))
        for bar in known.error_bars
    )
    assert replace(known, error_bars=bars).growth_sign == 1


def test_bars_are_kept_and_shown(coarse_stability: Stability, tmp_path: Path) -> None:
    result = with_bars(coarse_stability, [0.00321, 0.5])
    again = load(save(result, tmp_path / "result.nc"))
    assert isinstance(again, Stability)
    assert again.error_bars == result.error_bars
    content = summary(result)
    assert [bar["total"] for bar in content["error_bars"]] == [0.00321, 0.5]
    assert content["growth_sign"] == result.growth_sign
    console = Console(record=True, width=140)
    show(result, console)
    assert console.export_text().count("0.00321") == 2


def test_picture(coarse_stability: Stability, tmp_path: Path) -> None:
    path = saved(draw_error_bars(with_bars(coarse_stability, [0.01, 0.002])), tmp_path / "bars.png")
    assert path.stat().st_size > 10_000
    with pytest.raises(CaseError, match="without error bars"):
        draw_error_bars(coarse_stability).savefig(path)


def test_what_is_refused(coarse_stability: Stability, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(CaseError, match=r"error_bars = 0 is not allowed; allowed: .* >= 1"):
        with_error_bars(coarse_stability, count=0)
    case = ["stability", "--diameter", "6", "--packing", "0.2"]
    assert main([*case, "--error-bars", "0"]) == 2
    assert "error_bars = 0" in capsys.readouterr().err
    assert main([*case, "--error-bars", "2.5"]) == 2
    assert "2.5" in capsys.readouterr().err
