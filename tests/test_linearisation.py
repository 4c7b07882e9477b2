"""The blocks of the linear dynamics against the full matrix, and that against differences."""

import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import linear_sum_assignment

from celltrain import Base, Stability
from celltrain.harmonics import azimuthal_basis
from celltrain.stability import ExactDerivative, FiniteDifference, full_matrix, linear_blocks
from celltrain.train import place_cells


@pytest.fixture(scope="module")
def matrix(coarse_base: Base) -> np.ndarray:
    """The full matrix [cell, size, cell, size]."""
    cells, size = coarse_base.train.cells, coarse_base.coefficients.size
    return full_matrix(coarse_base).reshape(cells, size, cells, size)


def wave_matrix(matrix: np.ndarray, wave: int) -> np.ndarray:
    """What the full matrix does to disturbances exp(2 pi i wave p/N) of the cells p."""
    cells = len(matrix)
    phases = np.exp(2j * np.pi * wave * np.arange(cells) / cells)
    return np.einsum("spt,p->st", matrix[0], phases)


def flat_basis(base: Base, m: int) -> np.ndarray:
    basis = azimuthal_basis(base.train.degree, m)
    return basis.reshape(len(basis), -1)


def test_each_cell_acts_on_the_others_alike(coarse_base: Base, matrix: np.ndarray) -> None:
    # The full matrix is laid out from the answers to cell 0. Here cell 1 is disturbed: cells
    # listed in another order, at other places of the same tube.
    train = coarse_base.train
    shapes = np.roll(place_cells(coarse_base.coefficients, train, train.cells), -1, axis=0)
    derivative = ExactDerivative()
    size = coarse_base.coefficients.size
    directions = np.eye(size).reshape(size, *coarse_base.coefficients.shape)
    columns = derivative.columns(
        derivative.operator(coarse_base), jnp.asarray(shapes), jnp.asarray(directions), 12
    )
    found = np.asarray(columns).reshape(size, train.cells, size)
    expected = matrix[:, :, 0].transpose(2, 0, 1)
    assert_allclose(found, expected, rtol=0, atol=1e-8 * np.abs(matrix).max())
    assert_allclose(matrix[1, :, 2], matrix[0, :, 1], rtol=0, atol=0)


@pytest.mark.parametrize("wave", [0, 1])
def test_blocks_are_those_of_the_full_matrix(
    wave: int, coarse_base: Base, coarse_stability: Stability, matrix: np.ndarray
) -> None:
    full = wave_matrix(matrix, wave)
    size = np.abs(full).max()
    numbers = coarse_stability.azimuthal_numbers
    assert numbers == tuple(range(coarse_base.train.degree + 1))
    for m in numbers:
        basis = flat_basis(coarse_base, m)
        moved = full @ basis.T
        block = coarse_stability.blocks[m][wave]
        assert_allclose(basis @ moved, block, rtol=0, atol=3e-7 * size)
        # Nothing else is set in motion, neither another m nor the mirrored family.
        assert_allclose(moved, basis.T @ block, rtol=0, atol=3e-7 * size)


def test_opposite_waves_are_conjugate(coarse_base: Base, coarse_stability: Stability) -> None:
    numbers = coarse_stability.azimuthal_numbers
    q = -2 * np.pi / 3 * np.ones(1)
    opposite = linear_blocks(coarse_base.train, coarse_base.coefficients, q, numbers)
    for m in numbers:
        here = coarse_stability.blocks[m]
        size = np.abs(here[1]).max()
        assert_allclose(opposite[m][0], here[1].conj(), rtol=0, atol=1e-12 * size)
        if m < 3:
            assert np.abs(here[1].imag).max() > 1e-3 * size
        assert_allclose(here[0].imag, 0.0, atol=1e-12 * size)


def test_spectrum_of_the_full_matrix_is_that_of_all_blocks(
    coarse_stability: Stability, matrix: np.ndarray
) -> None:
    size = matrix.shape[0] * matrix.shape[1]
    full = np.linalg.eigvals(matrix.reshape(size, size))
    blocks, neutral = [], []
    for mode in coarse_stability.modes:
        value = complex(mode.growth_rate, mode.frequency)
        wave = 2 if mode.wave_number else 1
        # Half of the copies belong to the opposite wave.
        copies = [value, value.conjugate()][:wave] * (mode.multiplicity // wave)
        blocks += copies
        neutral += [mode.neutral] * len(copies)
    blocks, neutral = np.array(blocks), np.array(neutral)
    assert blocks.size == size
    distance = np.abs(full[:, None] - blocks)
    rows, columns = linear_sum_assignment(distance)
    errors = distance[rows, columns]
    assert neutral.sum() == 2 * 3 + 1
    assert_allclose(errors[~neutral[columns]], 0.0, atol=1e-5)
    # Volume and displacement are a double zero, which the solver may split.
    assert_allclose(errors[neutral[columns]], 0.0, atol=1e-4)


def test_differences_approach_the_exact_matrix(coarse_base: Base, matrix: np.ndarray) -> None:
    # A few of the columns; the differences are one-sided, as the paper's.
    train, size = coarse_base.train, coarse_base.coefficients.size
    shapes = jnp.asarray(place_cells(coarse_base.coefficients, train, train.cells))
    chosen = [1, 3, 40, 41, 75, 78]
    directions = jnp.eye(size)[jnp.array(chosen)].reshape(-1, *coarse_base.coefficients.shape)
    exact = matrix[:, :, 0][:, :, chosen]

    def error(step: float) -> float:
        derivative = FiniteDifference(step)
        columns = derivative.columns(derivative.operator(coarse_base), shapes, directions, 1)
        found = np.asarray(columns).reshape(len(chosen), train.cells, size)
        return float(np.abs(found.transpose(1, 2, 0) - exact).max())

    errors = error(1e-2), error(1e-3)
    assert np.log10(errors[0] / errors[1]) == pytest.approx(1, abs=0.1)
    assert errors[1] < 1e-2 * np.abs(exact).max()
