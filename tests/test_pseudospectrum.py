"""Pseudospectra, the Kreiss constant, adjoint modes and what they say."""

import numpy as np
import pytest
import scipy.linalg
from drawn import saved
from numpy.testing import assert_allclose

from celltrain import CaseError, Stability
from celltrain.analyses.pseudospectrum import BlockPseudospectrum
from celltrain.pictures import draw_pseudospectrum, draw_structural_sensitivity
from celltrain.stability import (
    NORMS,
    PaperNorm,
    Window,
    biorthogonality_error,
    condition_number,
    kreiss_constant,
    mode_vectors,
    normed_blocks,
    propagator_norm,
    pseudospectrum,
    receptivity,
    structural_sensitivity,
)
from celltrain.stability.adjoint import meridian_displacement
from celltrain.stability.pseudospectrum import smallest_singular_value

PLACES = [(0, 0), (0, 1), (1, 0), (1, 1), (2, 1)]


def test_normal_matrix() -> None:
    random = np.random.default_rng(0)
    turn, _ = np.linalg.qr(random.normal(size=(6, 6)) + 1j * random.normal(size=(6, 6)))
    values = random.normal(size=6) + 1j * random.normal(size=6)
    matrix = turn @ np.diag(values) @ turn.conj().T
    smallest = smallest_singular_value(matrix)
    for z in random.normal(size=5) + 1j * random.normal(size=5):
        assert_allclose(smallest(complex(z)), np.abs(z - values).min(), rtol=1e-10)
    assert_allclose(kreiss_constant(matrix).constant, 1.0, rtol=1e-9)


@pytest.mark.parametrize("coupling", [0.5, 3.0, 40.0])
def test_kreiss_constant_known_in_closed_form(coupling: float) -> None:
    # exp((B + 1) t) goes up to [[1, c], [0, 0]], and the resolvent times its distance, too.
    matrix = np.array([[-1.0, coupling], [0.0, -2.0]], dtype=complex)
    found = kreiss_constant(matrix)
    assert_allclose(found.constant, np.hypot(1.0, coupling), rtol=1e-9)
    assert_allclose(found.point, -1.0, atol=1e-9)


def test_kreiss_constant_away_from_the_abscissa() -> None:
    # Two Jordan-like pairs: the leading eigenvalue is harmless, the pair to its left is not.
    matrix = scipy.linalg.block_diag(
        [[0.0]], [[-1.0 + 2.0j, 50.0], [0.0, -1.1 + 2.0j]], [[-3.0, 4.0], [0.0, -3.0]]
    ).astype(complex)
    found = kreiss_constant(matrix)
    x = np.geomspace(1e-3, 1e2, 200)[:, None]
    y = 2.0 + np.linspace(-3.0, 3.0, 61)
    smallest = np.vectorize(smallest_singular_value(matrix))(x + 1j * y)
    brute = float((x / smallest).max())
    assert brute > 5.0
    assert brute * (1.0 - 1e-9) <= found.constant <= 1.01 * brute
    times = np.linspace(0.0, 8.0, 200)
    assert found.constant <= propagator_norm(matrix, times).max() <= np.e * 5 * found.constant
    assert found.point.real > 0.1


@pytest.mark.parametrize(("m", "j"), PLACES)
def test_pseudospectra_of_a_train(coarse_stability: Stability, m: int, j: int) -> None:
    result = pseudospectrum(coarse_stability, m, j, points=9)
    block = normed_blocks(coarse_stability, PaperNorm())[m, j]
    size = np.linalg.norm(block.matrix, 2)
    smallest = smallest_singular_value(block.matrix)
    # The spectrum is inside, for any epsilon.
    assert max(smallest(complex(value)) for value in result.eigenvalues) < 1e-10 * size
    z = result.real + 1j * result.imaginary[:, None]
    distance = np.abs(z[..., None] - result.eigenvalues).min(axis=-1)
    assert (result.smallest <= distance + 1e-9).all()
    # Not further right than the numerical range.
    assert (result.smallest >= z.real - result.numerical_abscissa - 1e-9).all()
    direct = np.linalg.svd(z[2, 3] * np.eye(len(block.matrix)) - block.matrix)[1][-1]
    assert_allclose(result.smallest[2, 3], direct, rtol=1e-8, atol=1e-12)
    # A change of size epsilon moves eigenvalues to where the level is epsilon or less.
    random = np.random.default_rng(m + 10 * j)
    change = random.normal(size=block.matrix.shape)
    change *= 0.1 / np.linalg.norm(change, 2)
    moved = scipy.linalg.eigvals(block.matrix + change)
    assert max(smallest(complex(value)) for value in moved) <= 0.1 * (1.0 + 1e-9)
    # The Kreiss theorem, with the leading mode's growth taken out.
    count = len(block.matrix)
    shifted = block.matrix - result.spectral_abscissa * np.eye(count)
    times = np.concatenate([np.geomspace(1e-3, 100.0, 60), [1e4, 1e6]])
    largest = propagator_norm(shifted, times).max()
    constant = result.kreiss.constant
    assert 1.0 <= constant <= largest * (1.0 + 1e-6)
    assert largest <= np.e * count * constant


def test_left_and_right_vectors_are_biorthogonal(coarse_stability: Stability) -> None:
    result = coarse_stability
    for m in result.azimuthal_numbers:
        for j in range(len(result.wave_numbers)):
            here = [x for x in result.modes if (x.azimuthal_number, x.wave_number) == (m, j)]
            other = [mode.index for mode in here if not mode.neutral]
            neutral = [mode.index for mode in here if mode.neutral]
            left, right = result.left_vectors[m][j], result.right_vectors[m][j]
            product = left.conj().T @ right
            assert_allclose(product[np.ix_(other, other)], np.eye(len(other)), atol=1e-10)
            assert biorthogonality_error(left[:, other], right[:, other]) < 1e-10
            size = np.linalg.norm(left, axis=0)[:, None] * np.linalg.norm(right, axis=0)
            cross = np.abs(product) / size
            assert cross[np.ix_(other, neutral)].max(initial=0.0) < 1e-10
            assert cross[np.ix_(neutral, other)].max(initial=0.0) < 1e-10


def test_biorthogonality_error_sees_an_error() -> None:
    random = np.random.default_rng(4)
    _, left, right = scipy.linalg.eig(random.normal(size=(5, 5)), left=True)
    left = left / np.sum(left.conj() * right, axis=0).conj()
    assert biorthogonality_error(left, right) < 1e-12
    wrong = left + 1e-3 * left[:, ::-1]
    assert biorthogonality_error(wrong, right) > 1e-4


def some_modes(result: Stability) -> list:
    modes = [mode for mode in result.modes if not mode.neutral]
    return [next(x for x in modes if (x.azimuthal_number, x.wave_number) == p) for p in PLACES]


def test_condition_number_is_how_far_an_eigenvalue_moves(coarse_stability: Stability) -> None:
    for norm in NORMS:
        blocks = normed_blocks(coarse_stability, norm)
        for mode in some_modes(coarse_stability):
            block = blocks[mode.azimuthal_number, mode.wave_number]
            number = condition_number(coarse_stability, mode, norm=norm)
            assert number >= 1.0
            left, right = mode_vectors(coarse_stability, mode)
            left, right = block.lift.T @ left, block.reduce @ right
            # The worst change of unit size.
            worst = np.outer(left, right.conj())
            worst /= np.linalg.norm(worst, 2)
            step = 1e-6 / number
            value = complex(mode.growth_rate, mode.frequency)
            moved = scipy.linalg.eigvals(block.matrix + step * worst)
            distance = np.abs(moved - value).min()
            assert_allclose(distance / step, number, rtol=1e-2)


def test_sensitivity_along_the_meridian(coarse_stability: Stability) -> None:
    result = coarse_stability
    for mode in some_modes(result):
        m = mode.azimuthal_number
        found = structural_sensitivity(result, mode)
        left, right = mode_vectors(result, mode)
        fields = [meridian_displacement(v, 6, m, found.theta) for v in (left, right)]
        # The inner product over the sphere is that of the coefficients.
        density = np.sum(fields[0].conj() * fields[1], axis=0) * np.sin(found.theta)
        overlap = 2.0 * np.pi * np.trapezoid(density, found.theta) / (2.0 if m > 0 else 1.0)
        assert_allclose(overlap, 1.0, atol=1e-4 * np.linalg.norm(left))
        assert_allclose(found.direct, np.linalg.norm(fields[1], axis=0), rtol=1e-12)
        assert found.integral >= 1.0 - 1e-4
        # By Cauchy and Schwarz.
        condition = condition_number(result, mode)
        assert found.integral <= condition * (1.0 + 1e-4)


def test_receptivity_finds_a_mode_in_a_disturbance(coarse_stability: Stability) -> None:
    result = coarse_stability
    modes = [
        mode
        for mode in result.modes
        if not mode.neutral
        and (mode.azimuthal_number, mode.wave_number) == (1, 0)
        and abs(mode.frequency) < 1e-12
    ]
    first, second = modes[:2]
    disturbance = 3.0 * result.shape(first) + 0.5 * result.shape(second)
    assert_allclose(abs(receptivity(result, first, disturbance)), 3.0, rtol=1e-9)
    assert_allclose(abs(receptivity(result, second, disturbance)), 0.5, rtol=1e-9)
    wave = next(x for x in result.modes if (x.azimuthal_number, x.wave_number) == (1, 1))
    assert_allclose(receptivity(result, wave, disturbance), 0.0, atol=1e-12)


def test_what_is_refused(coarse_stability: Stability) -> None:
    with pytest.raises(CaseError, match="azimuthal_number = 9"):
        pseudospectrum(coarse_stability, 9, 0)
    asked = {"azimuthal_number": 1, "wave_number": 0}
    with pytest.raises(CaseError, match=r"azimuthal_number = 1 .* azimuthal_numbers \(2, 3\)"):
        BlockPseudospectrum(azimuthal_numbers=(2, 3), **asked).check(coarse_stability.base.train)
    BlockPseudospectrum(azimuthal_numbers=(1, 3), **asked).check(coarse_stability.base.train)
    with pytest.raises(CaseError, match=r"wave_number = 2 .* 0 to 1"):
        pseudospectrum(coarse_stability, 1, 2)
    with pytest.raises(CaseError, match="left < right"):
        Window(1.0, 0.0, -1.0, 1.0)
    neutral = next(mode for mode in coarse_stability.modes if mode.neutral)
    with pytest.raises(CaseError, match="neutral"):
        structural_sensitivity(coarse_stability, neutral)
    with pytest.raises(CaseError, match="neutral"):
        condition_number(coarse_stability, neutral)


def test_pictures(coarse_stability: Stability, tmp_path) -> None:
    window = Window(-2.0, 1.0, -1.0, 1.0)
    result = pseudospectrum(coarse_stability, 1, 0, window=window, points=15)
    assert (result.real[0], result.imaginary[-1]) == (-2.0, 1.0)
    assert saved(draw_pseudospectrum(result), tmp_path / "levels.png").stat().st_size > 10_000
    found = structural_sensitivity(coarse_stability, coarse_stability.leading, points=91)
    drawn = saved(draw_structural_sensitivity(found), tmp_path / "sensitivity.png")
    assert drawn.stat().st_size > 10_000
