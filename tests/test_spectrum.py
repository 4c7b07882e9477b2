"""Eigenvalues, vectors on both sides, neutral modes, norms, and growth at the first moment."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
from numpy.testing import assert_allclose

from celltrain import Base, CaseError, Stability, Train, stability, steady
from celltrain.harmonics import UNIT_DISPLACEMENT, azimuthal_basis, degrees_and_orders
from celltrain.stability import (
    NORMS,
    Norm,
    OrthonormalNorm,
    PaperNorm,
    SurfaceNorm,
    block_spectrum,
    deflated,
    neutral_defects,
    neutral_space,
    numerical_abscissa,
)
from celltrain.stability.neutral import NeutralSpace

Q, _ = np.linalg.qr(np.random.default_rng(0).normal(size=(12, 12)))


def made_up(complex_: bool = False) -> tuple[np.ndarray, NeutralSpace]:
    """A far from normal matrix with n^H A = 0 and A r = A t = 0, where n is normal to r and t."""
    random = np.random.default_rng(1)
    matrix = random.normal(size=(12, 12)) + 3 * np.triu(random.normal(size=(12, 12)))
    matrix = matrix + complex_ * 1j * random.normal(size=(12, 12))
    right, volume = Q[:, :2], Q[:, 2]
    matrix = matrix @ (np.eye(12) - right @ right.T)
    matrix = (np.eye(12) - np.outer(volume, volume)) @ matrix
    return matrix, NeutralSpace(right, ("rotation", "translation"), volume)


@pytest.mark.parametrize("complex_", [False, True])
def test_neutral_modes_are_taken_out_of_a_matrix(complex_: bool) -> None:
    matrix, neutral = made_up(complex_)
    found = block_spectrum(matrix, neutral)
    assert sorted(found.kinds) == [""] * 9 + ["rotation", "translation", "volume"]
    assert (np.diff(found.eigenvalues.real) <= 0).all()
    other = np.array([kind == "" for kind in found.kinds])
    # The solver's own, without those at zero: r, t and the volume.
    expected = np.linalg.eigvals(matrix)
    expected = expected[np.argsort(np.abs(expected))][3:]
    near = np.abs(found.eigenvalues[other][:, None] - expected).min(axis=0)
    assert_allclose(near, 0.0, atol=1e-10)
    assert_allclose(found.eigenvalues[~other], 0.0, atol=1e-13)
    right, left = found.right, found.left
    values = found.eigenvalues[other]
    off = matrix @ right[:, other] - right[:, other] * values
    assert_allclose(off, 0.0, atol=1e-11)
    off = left[:, other].conj().T @ matrix - values[:, None] * left[:, other].conj().T
    assert_allclose(off, 0.0, atol=1e-10)
    assert_allclose(np.linalg.norm(right, axis=0), 1.0, rtol=1e-12)
    product = left.conj().T @ right
    assert_allclose(np.diag(product), 1.0, rtol=0, atol=1e-11)
    # Modes of different eigenvalues, and neutral ones against the others.
    assert_allclose(product[np.ix_(other, other)], np.eye(9), rtol=0, atol=1e-10)
    assert_allclose(product[np.ix_(~other, other)], 0.0, atol=1e-10)
    assert_allclose(product[np.ix_(other, ~other)], 0.0, atol=1e-10)


def test_double_zero_is_not_split() -> None:
    # A volume that displaces: A n = ... + t is a Jordan block, zero as a double eigenvalue.
    matrix, neutral = made_up()
    matrix = matrix + np.outer(Q[:, 1], neutral.volume)
    noise = 1e-9 * np.random.default_rng(2).normal(size=(12, 12))
    split = np.sort(np.abs(np.linalg.eigvals(matrix + noise)))[:3]
    assert split.max() > 1e-6
    found = block_spectrum(matrix + noise, neutral)
    neutral_values = [v for v, kind in zip(found.eigenvalues, found.kinds, strict=True) if kind]
    assert np.abs(neutral_values).max() < 1e-8


def test_known_null_vectors_of_a_train(coarse_stability: Stability) -> None:
    base = coarse_stability.base
    for wave, block in enumerate(coarse_stability.blocks[0]):
        neutral = neutral_space(base, 0, wave)
        assert neutral.kinds == (("rotation", "translation") if wave == 0 else ("rotation",))
        size = np.linalg.norm(block, 2)
        # The rates conserve the volume exactly, which differentiated leaves how far the train is
        # from steady on all meridians; a turn or a shift is seen by the sums.
        assert np.linalg.norm(neutral.volume @ block) < 0.1 * base.train.resolution.tolerance
        assert np.linalg.norm(block @ neutral.right) < 1e-6 * size
    assert neutral_space(base, 1, 0).count == 0


def test_deflation_is_exact(coarse_stability: Stability) -> None:
    base = coarse_stability.base
    for wave, block in enumerate(coarse_stability.blocks[0]):
        neutral = neutral_space(base, 0, wave)
        exact = deflated(block, neutral)
        assert neutral.volume is not None
        assert_allclose(exact @ neutral.right, 0.0, atol=1e-13)
        assert_allclose(neutral.volume @ exact, 0.0, atol=1e-13)
        # Nothing else is touched: on the complement it is the same dynamics.
        rest = scipy.linalg.null_space(np.column_stack([neutral.right, neutral.volume]).T)
        assert_allclose(rest.T @ exact @ rest, rest.T @ block @ rest, rtol=0, atol=1e-12)
    for mode in coarse_stability.modes:
        if mode.neutral:
            assert abs(complex(mode.growth_rate, mode.frequency)) < 1e-12


def test_what_deflation_takes_away_is_told(coarse_stability: Stability) -> None:
    # Wrong by 1e-5 in all entries, the dynamics keeps its neutral modes, and says how wrong it is.
    random = np.random.default_rng(8)
    block = coarse_stability.blocks[0]
    noisy = block + 1e-5 * random.normal(size=block.shape)
    wrong = replace(coarse_stability, blocks={0: noisy}, azimuthal_numbers=(0,))
    defects = neutral_defects(wrong)
    assert [each.kind for each in defects] == [
        "rotation", "translation", "volume", "rotation", "volume",
    ]  # fmt: skip
    for each in defects:
        neutral = neutral_space(wrong.base, 0, each.wave_number)
        assert 1e-7 < abs(each.raw) <= each.residual < 1e-3
        found = block_spectrum(noisy[each.wave_number], neutral)
        values = found.eigenvalues[[kind == each.kind for kind in found.kinds]]
        assert np.abs(values).max() < 1e-12
    size = max(each.residual for each in neutral_defects(coarse_stability))
    assert size < 1e-6 * np.linalg.norm(block[0], 2)


def test_vectors_of_a_train(coarse_stability: Stability) -> None:
    for m in coarse_stability.azimuthal_numbers:
        for wave, block in enumerate(coarse_stability.blocks[m]):
            values = coarse_stability.eigenvalues[m][wave]
            right = coarse_stability.right_vectors[m][wave]
            left = coarse_stability.left_vectors[m][wave]
            neutral = {
                mode.index
                for mode in coarse_stability.modes
                if mode.neutral and (mode.azimuthal_number, mode.wave_number) == (m, wave)
            }
            assert len(neutral) == neutral_space(coarse_stability.base, m, wave).count
            other = np.array([i for i in range(len(values)) if i not in neutral])
            size = np.linalg.norm(block, 2)
            off = block @ right[:, other] - right[:, other] * values[other]
            assert_allclose(off, 0.0, atol=1e-9 * size)
            left_size = np.linalg.norm(left[:, other], axis=0)[:, None]
            off = left[:, other].conj().T @ block - values[other][:, None] * left[:, other].conj().T
            assert_allclose(off / left_size, 0.0, atol=1e-9 * size)
            overlap = np.sum(left.conj() * right, axis=0)
            assert_allclose(overlap, 1.0, rtol=0, atol=1e-9)


def test_modes_are_all_there_in_order(coarse_stability: Stability) -> None:
    train, modes = coarse_stability.base.train, coarse_stability.modes
    assert sum(mode.multiplicity for mode in modes) == 3 * train.cells * train.degree**2
    rates = [mode.growth_rate for mode in modes]
    assert rates == sorted(rates, reverse=True)
    for mode in modes[::17]:
        value = coarse_stability.eigenvalues[mode.azimuthal_number][mode.wave_number, mode.index]
        assert value == complex(mode.growth_rate, mode.frequency)
    kinds = [mode.neutral_kind for mode in modes for _ in range(mode.multiplicity) if mode.neutral]
    assert sorted(kinds) == ["rotation"] * 3 + ["translation"] + ["volume"] * 3
    others = [mode.growth_rate for mode in modes if not mode.neutral]
    assert coarse_stability.spectral_abscissa == coarse_stability.leading.growth_rate == max(others)


def test_a_mode_as_shapes_keeps_its_form(coarse_stability: Stability) -> None:
    # With s(phase) = Re(w exp(i phase)), A s(0) lies in the plane of s(0) and s(pi/2), and its
    # part along s(0) is the growth rate.
    base = coarse_stability.base
    assert base.train.cells == 3
    mode = next(
        mode
        for mode in coarse_stability.modes
        if mode.wave_number == 1 and mode.azimuthal_number == 1
    )
    basis = azimuthal_basis(base.train.degree, 1)
    here, later = coarse_stability.shape(mode), coarse_stability.shape(mode, np.pi / 2)
    assert_allclose(np.linalg.norm(here, axis=(1, 2)).max(), 1.0, rtol=1e-12)
    waves = np.fft.fft(np.einsum("uik,pik->pu", basis, here), axis=0)
    blocks = coarse_stability.blocks[1]
    moved = np.stack([blocks[0] @ waves[0], blocks[1] @ waves[1], blocks[1].conj() @ waves[2]])
    rate = np.einsum("uik,pu->pik", basis, np.fft.ifft(moved, axis=0))
    assert_allclose(rate.imag, 0.0, atol=1e-12)
    plane = np.stack([here.ravel(), later.ravel()], axis=1)
    solved, *_ = np.linalg.lstsq(plane, rate.real.ravel(), rcond=None)
    assert_allclose(plane @ solved, rate.real.ravel(), rtol=0, atol=1e-11)
    assert_allclose(solved[0], mode.growth_rate, rtol=0, atol=1e-11)


def test_numerical_abscissa_is_the_growth_at_the_first_moment() -> None:
    random = np.random.default_rng(3)
    matrix, _ = made_up(complex_=True)
    root = random.normal(size=(12, 12))
    gram = root.T @ root + np.eye(12)
    rate, vector = numerical_abscissa(matrix, gram)

    def size(disturbance: np.ndarray) -> float:
        return float(np.sqrt((disturbance.conj() @ gram @ disturbance).real))

    def growth(disturbance: np.ndarray, time: float) -> float:
        ahead, behind = (size(scipy.linalg.expm(t * matrix) @ disturbance) for t in (time, -time))
        return (ahead - behind) / (2 * time * size(disturbance))

    assert_allclose(growth(vector, 1e-6), rate, rtol=1e-6)
    others = random.normal(size=(50, 12)) + 1j * random.normal(size=(50, 12))
    assert max(growth(other, 1e-6) for other in others) < rate
    assert rate >= np.linalg.eigvals(matrix).real.max()


def test_numerical_abscissas_of_a_train(coarse_stability: Stability) -> None:
    result = coarse_stability
    assert set(result.numerical_abscissas) == {"paper", "orthonormal", "surface"}
    assert result.numerical_abscissa == result.numerical_abscissas["paper"]
    assert min(result.numerical_abscissas.values()) >= result.spectral_abscissa
    for norm in NORMS:
        largest = 0.0
        for m, gram in norm.grams(result.base.coefficients, result.azimuthal_numbers).items():
            # With the root of the Gram matrix as coordinates the norm is the plain one.
            root = np.linalg.cholesky(gram).T
            for block in result.blocks[m]:
                plain = root @ block @ np.linalg.inv(root)
                largest = max(largest, np.linalg.eigvalsh(0.5 * (plain + plain.conj().T))[-1])
        assert_allclose(result.numerical_abscissas[norm.name], largest, rtol=1e-10)
    best = result.transient
    assert best.growth_rate == result.numerical_abscissa
    block = result.blocks[best.azimuthal_number][best.wave_number]
    gram = gram_of(PaperNorm(), result.base.coefficients, best.azimuthal_number)
    weighted = best.vector.conj() @ gram
    growth = (weighted @ block @ best.vector).real / (weighted @ best.vector).real
    assert_allclose(growth, best.growth_rate, rtol=1e-10)


def gram_of(norm: Norm, shape: np.ndarray, m: int) -> np.ndarray:
    return norm.grams(shape, [m])[m]


@pytest.mark.parametrize("m", [0, 1, 2])
def test_norms_are_what_they_are_defined_to_be(m: int) -> None:
    degree = 6
    shape = np.random.default_rng(4).normal(size=(3, degree**2))
    basis = azimuthal_basis(degree, m)
    amounts = np.random.default_rng(5).normal(size=len(basis))
    disturbance = np.einsum("u,uik->ik", amounts, basis)
    assert_allclose(
        amounts @ gram_of(OrthonormalNorm(), shape, m) @ amounts, np.sum(disturbance**2), rtol=1e-12
    )
    _, order = degrees_and_orders(degree)
    paper = disturbance / np.where(order == 0, np.sqrt(2 * np.pi), np.sqrt(np.pi))
    assert_allclose(
        amounts @ gram_of(PaperNorm(), shape, m) @ amounts, np.sum(paper**2), rtol=1e-12
    )


def test_surface_norm_weighs_by_area(coarse_stability: Stability) -> None:
    # A unit displacement has unit norm whatever the shape: along the tube m = 0, across m = 1.
    shape = coarse_stability.base.coefficients
    for m, axis in ((0, 2), (1, 0)):
        displaced = np.zeros_like(shape)
        displaced[axis, 0] = UNIT_DISPLACEMENT
        amounts = np.einsum("uik,ik->u", azimuthal_basis(6, m), displaced)
        gram = gram_of(SurfaceNorm(), shape, m)
        assert_allclose(amounts @ gram @ amounts, 1.0, rtol=1e-12)
    # On a sphere the area is the solid angle: 1/(4 pi) of the orthonormal norm.
    sphere = np.zeros_like(shape)
    sphere[0, 3], sphere[1, 1], sphere[2, 2] = np.sqrt(4 * np.pi / 3) * np.ones(3)
    assert_allclose(
        gram_of(SurfaceNorm(), sphere, 1) * 4 * np.pi,
        gram_of(OrthonormalNorm(), sphere, 1),
        atol=1e-12,
    )


def test_what_cannot_be_analysed_is_refused(coarse_stability: Stability) -> None:
    base = coarse_stability.base
    with pytest.raises(CaseError, match=r"azimuthal_numbers = 7 .* degree, 6"):
        stability(base, azimuthal_numbers=[0, 7])
    with pytest.raises(CaseError, match="azimuthal_numbers = none"):
        stability(base, azimuthal_numbers=[])


def test_no_error_estimate_where_a_higher_degree_is_not_allowed(coarse_base: Base) -> None:
    own_grid = coarse_base.train.changed(target_order=coarse_base.train.degree + 1)
    result = stability(replace(coarse_base, train=own_grid), azimuthal_numbers=[1])
    assert np.isnan(result.error_estimate)
    assert result.leading.azimuthal_number == 1


@pytest.mark.slow
def test_train_of_the_paper() -> None:
    """D = 6, phi = 0.2: an unstable train, at the paper's resolution; rates in U/r0."""
    base = steady(Train(diameter=6, packing=0.2, cells=8, degree=12))
    assert_allclose(base.cell_velocity, 1.7720, rtol=1e-3)
    assert_allclose(base.largest_radius, 1.277, rtol=2e-3)
    result = stability(base, azimuthal_numbers=[0, 1], estimate_error=False)
    assert_allclose(result.spectral_abscissa, 0.01175, rtol=2e-2)
    assert_allclose(result.numerical_abscissa, 1.954, rtol=1e-2)
    assert (result.leading.azimuthal_number, result.leading.wave_number) == (1, 0)
    assert result.transient.azimuthal_number == 1
