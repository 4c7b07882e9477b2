"""Transient growth: coordinates of a norm, the strain norm, G(t) and the optimal disturbance."""

import json
from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
from drawn import saved
from numpy.testing import assert_allclose

from celltrain import Base, CaseError, Stability
from celltrain.cli import main
from celltrain.contract import analysis, load
from celltrain.pictures import draw_transient_growth
from celltrain.results import save
from celltrain.stability import (
    NORMS,
    Norm,
    PaperNorm,
    StrainNorm,
    SurfaceNorm,
    neutral_space,
    normed_block,
    normed_blocks,
    numerical_abscissa,
    optimal_disturbance,
    propagator_norm,
    transient_growth,
)
from celltrain.stability.neutral import NeutralSpace
from celltrain.stability.strain_norm import rigid_motions
from celltrain.stability.transient import growth_peak

COUPLING = 10.0
JORDAN = np.array([[-1.0, COUPLING], [0.0, -1.0]], dtype=complex)


def jordan_growth(times: np.ndarray) -> np.ndarray:
    """|exp(J t)|: exp(-t) times the larger singular value of a shear by c t."""
    return np.exp(-times + np.arcsinh(0.5 * COUPLING * times))


def test_growth_of_a_jordan_block() -> None:
    times = np.array([0.0, 0.01, 0.3, 1.0, 4.0])
    assert_allclose(propagator_norm(JORDAN, times), jordan_growth(times), rtol=1e-12)
    block = normed_block(JORDAN, np.eye(2))
    assert_allclose(block.numerical_abscissa, 0.5 * COUPLING - 1.0, rtol=1e-12)
    assert_allclose(block.spectral_abscissa, -1.0, atol=1e-7)
    times = np.linspace(0.0, 4.0, 12)
    peak = growth_peak(JORDAN, times, jordan_growth(times))
    when = np.sqrt(1.0 - 4.0 / COUPLING**2)
    assert peak.interior
    assert_allclose(peak.time, when, rtol=1e-6)
    assert_allclose(peak.growth, jordan_growth(np.array([when]))[0], rtol=1e-12)


def test_growth_that_does_not_pass() -> None:
    times = np.linspace(0.0, 2.0, 9)
    for rate, time, interior in ((0.5, 2.0, False), (-0.5, 0.0, True)):
        peak = growth_peak(np.array([[rate + 0j]]), times, np.exp(rate * times))
        assert (peak.time, peak.growth, peak.interior) == (time, np.exp(rate * time), interior)


def test_coordinates_of_a_norm() -> None:
    random = np.random.default_rng(1)
    full, _ = np.linalg.qr(random.normal(size=(9, 9)))
    right, volume = full[:, :2], full[:, 2]
    matrix = random.normal(size=(9, 9)) + 1j * random.normal(size=(9, 9))
    matrix = (np.eye(9) - np.outer(volume, volume)) @ matrix @ (np.eye(9) - right @ right.T)
    root = random.normal(size=(9, 9))
    gram = root.T @ root + 0.1 * np.eye(9)
    neutral = NeutralSpace(right, ("rotation", "translation"), volume)
    block = normed_block(matrix, gram, neutral)
    assert block.matrix.shape == (6, 6)
    assert_allclose(block.reduce @ block.lift, np.eye(6), atol=1e-12)
    assert_allclose(block.lift.T @ gram @ block.lift, np.eye(6), atol=1e-12)
    assert_allclose(volume @ block.lift, 0.0, atol=1e-12)
    disturbance = random.normal(size=9) + 1j * random.normal(size=9)
    disturbance -= volume * (volume @ disturbance)
    # The norm is the smallest among those that differ by neutral displacements: a problem of least
    # squares.
    sides = np.linalg.cholesky(gram).T
    best, *_ = np.linalg.lstsq(sides @ right, sides @ disturbance, rcond=None)
    size = np.linalg.norm(sides @ (disturbance - right @ best))
    assert_allclose(np.linalg.norm(block.reduce @ disturbance), size, rtol=1e-12)
    moved = block.reduce @ (matrix @ disturbance)
    assert_allclose(moved, block.matrix @ block.reduce @ disturbance, atol=1e-12)
    with pytest.raises(CaseError, match="positive definite"):
        normed_block(matrix, gram - 100.0 * np.eye(9), neutral)


def norms(base: Base) -> list[Norm]:
    return [*NORMS, StrainNorm(base.train)]


def test_growth_of_a_train(coarse_stability: Stability) -> None:
    result = coarse_stability
    random = np.random.default_rng(2)
    for norm in norms(result.base):
        growth = transient_growth(result, norm=norm, until=5.0, samples=16)
        places = {(block.azimuthal_number, block.wave_number) for block in growth.blocks}
        assert places == {(m, j) for m in range(7) for j in range(2)}
        assert_allclose(growth.growth[0], 1.0, rtol=1e-12)
        rate = growth.spectral_abscissa
        assert_allclose(rate, result.spectral_abscissa, atol=1e-9)
        assert (growth.growth >= np.exp(rate * growth.times) * (1.0 - 1e-9)).all()
        assert (growth.growth <= np.exp(growth.numerical_abscissa * growth.times) + 1e-9).all()
        blocks = normed_blocks(result, norm)
        grams = norm.grams(result.base.coefficients, result.azimuthal_numbers)
        for each in growth.blocks:
            m, j = each.azimuthal_number, each.wave_number
            block = blocks[m, j]
            # Growth at the first moment, by differences of the second order.
            step = 1e-5
            slope = (propagator_norm(block.matrix, np.array([step]))[0] - 1.0) / step
            assert_allclose(slope, each.numerical_abscissa, atol=2e-3)
            if m > 0:
                eta, _ = numerical_abscissa(result.blocks[m][j], grams[m])
                assert_allclose(each.numerical_abscissa, eta, atol=1e-10)
            start = random.normal(size=len(block.matrix)) + 0j
            moved = scipy.linalg.expm(growth.times[-1] * block.matrix) @ start
            assert np.linalg.norm(moved) <= each.growth[-1] * np.linalg.norm(start) * (1 + 1e-9)


def test_two_disturbances_over_time(coarse_stability: Stability) -> None:
    growth = transient_growth(coarse_stability, until=3.0, samples=12)
    assert_allclose(growth.modal, np.exp(growth.spectral_abscissa * growth.times), rtol=1e-8)
    first = growth.times[1]
    slope = (growth.abrupt[1] - 1.0) / first
    assert_allclose(slope, growth.numerical_abscissa, rtol=0.05)
    assert (growth.abrupt <= growth.growth * (1.0 + 1e-9)).all()


@pytest.mark.parametrize("m", [0, 1, 2])
def test_optimal_disturbance_becomes_what_is_said(coarse_stability: Stability, m: int) -> None:
    result = coarse_stability
    gram = PaperNorm().grams(result.base.coefficients, [m])[m]
    for j in range(2):
        neutral = neutral_space(result.base, m, j)
        matrix = result.blocks[m][j]
        block = normed_block(matrix, gram, neutral)
        growth, initial, final = optimal_disturbance(block, 0.4)
        assert_allclose(growth, propagator_norm(block.matrix, np.array([0.4]))[0], rtol=1e-10)
        assert_allclose((initial.conj() @ gram @ initial).real, 1.0, rtol=1e-10)
        assert_allclose((final.conj() @ gram @ final).real, growth**2, rtol=1e-10)
        # The block's own exponential, up to rotation and displacement.
        reached = scipy.linalg.expm(0.4 * matrix) @ initial - final
        rest = reached - neutral.right @ (neutral.right.T @ reached)
        assert_allclose(rest, 0.0, atol=1e-6)


def test_peak_is_not_below_its_neighbours(coarse_stability: Stability) -> None:
    growth = transient_growth(coarse_stability, until=5.0, samples=24)
    optimal = growth.optimal
    place = optimal.azimuthal_number, optimal.wave_number
    block = normed_blocks(coarse_stability, PaperNorm())[place]
    near = optimal.time * np.array([0.99, 1.0, 1.01])
    below, here, above = propagator_norm(block.matrix, near)
    assert here >= max(below, above)
    assert_allclose(optimal.growth, here, rtol=1e-12)
    initial, final = optimal.shapes(coarse_stability)
    assert initial.shape == final.shape == (3, 3, 36)
    assert_allclose(np.linalg.norm(initial, axis=(1, 2)).max(), 1.0, rtol=1e-12)


def test_strain_norm_counts_rigid_motions_by_displacement(coarse_base: Base) -> None:
    shape = coarse_base.coefficients
    surface = SurfaceNorm().grams(shape, [0, 1, 2])
    single = StrainNorm(coarse_base.train).grams(shape, [0, 1, 2])
    double = StrainNorm(coarse_base.train, rigid_weight=2.0).grams(shape, [0, 1, 2])
    for m in (0, 1):
        rigid = rigid_motions(shape, m)
        assert_allclose(
            rigid.T @ single[m] @ rigid, rigid.T @ surface[m] @ rigid, rtol=1e-8, atol=1e-9
        )
        weight = double[m] - single[m]
        assert np.linalg.matrix_rank(weight, tol=1e-8) == 2
        assert scipy.linalg.eigvalsh(single[m])[0] > 0.0
    assert_allclose(double[2], single[2], rtol=1e-12)
    with pytest.raises(CaseError, match="rigid_weight = 0"):
        StrainNorm(coarse_base.train, rigid_weight=0.0)


def test_what_is_refused(coarse_stability: Stability) -> None:
    with pytest.raises(CaseError, match="until = -1"):
        transient_growth(coarse_stability, until=-1.0)
    with pytest.raises(CaseError, match="samples = 2"):
        transient_growth(coarse_stability, samples=2)


def test_picture(coarse_stability: Stability, tmp_path) -> None:
    growth = transient_growth(coarse_stability, until=5.0, samples=12)
    assert saved(draw_transient_growth(growth), tmp_path / "growth.png").stat().st_size > 10_000
    assert load(save(growth, tmp_path / "growth.nc")) == growth


def test_command(coarse_stability, monkeypatch, tmp_path, capsys) -> None:
    result = replace(coarse_stability)
    monkeypatch.setattr(analysis, "stability", lambda train, **_: result)
    case = ["transient", "--diameter", "6", "--packing", "0.3", "--cells", "3", "--degree", "6"]
    arguments = ["--norm", "surface", "--until", "4", "--plot", str(tmp_path), "--quiet"]
    assert main([*case, *arguments, "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    expected = transient_growth(result, norm=SurfaceNorm(), until=4.0)
    assert content["norm"] == "surface"
    assert_allclose(content["growth"], expected.growth, rtol=1e-12)
    assert content["optimal"]["time"] == expected.optimal.time
    assert [path.name for path in tmp_path.iterdir()] == ["transient_growth.png"]
    assert main([*case, "--quiet"]) == 0
    assert "initial growth rate (eta)" in capsys.readouterr().out


def test_command_refuses(capsys) -> None:
    assert main(["transient", "--diameter", "6", "--packing", "0.2", "--until", "0"]) == 2
    assert "until = 0 is not allowed" in capsys.readouterr().err
    assert main(["transient", "--diameter", "6", "--packing", "0.2", "--norm", "energy"]) == 2
    assert "orthonormal" in capsys.readouterr().err
