"""Blocks of the linear dynamics, from the meridian, beside the operator for any shapes.

That one computes the velocity in another way (Ewald sums, a wall on a grid, fast transforms), and
its derivatives are automatic. Both with fine rules: what the harmonics leave out is the same.
"""

import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain import Base, Train, stability, steady
from celltrain.harmonics import azimuthal_basis
from celltrain.membrane import place_cells
from celltrain.meridian.rules import choose_rules
from celltrain.stability import linear_blocks
from celltrain.stability.neighbours import couplings
from celltrain.train.full_matrix import (
    FiniteDifference,
    full_matrix,
    matrix_operator,
)

CELLS = 2
TRAIN = Train(
    diameter=6,
    packing=0.3,
    cells=CELLS,
    degree=6,
    source_order=22,
    polar_radial=38,
    polar_azimuthal=46,
    tolerance=1e-7,
)
PHASES = 2 * np.pi * np.arange(CELLS) / CELLS
NUMBERS = range(TRAIN.degree + 1)


@pytest.fixture(scope="module")
def base() -> Base:
    return steady(TRAIN, estimate_error=False)


@pytest.fixture(scope="module")
def matrix(base: Base) -> np.ndarray:
    """The full matrix [cell, size, cell, size]."""
    size = base.coefficients.size
    return full_matrix(base).reshape(CELLS, size, CELLS, size)


@pytest.fixture(scope="module")
def blocks(base: Base) -> dict[int, np.ndarray]:
    rules = choose_rules(
        base.profile,
        period=TRAIN.period,
        radius=TRAIN.radius,
        targets=TRAIN.sizes.target_order,
        tolerance=1e-10,
        radial=60,
        around=60,
    )
    return linear_blocks(base, PHASES, NUMBERS, rules=rules)


@pytest.mark.slow
@pytest.mark.parametrize("wave", range(CELLS))
def test_blocks_are_those_of_the_full_matrix(
    wave: int, matrix: np.ndarray, blocks: dict[int, np.ndarray]
) -> None:
    # What the matrix does to disturbances exp(i q p) of the cells p.
    full = np.einsum("spt,p->st", matrix[0], np.exp(1j * PHASES[wave] * np.arange(CELLS)))
    size = np.abs(full).max()
    for m in NUMBERS:
        basis = azimuthal_basis(TRAIN.degree, m).reshape(-1, len(full))
        block = blocks[m][wave]
        # Nothing else is set in motion, neither another m nor the mirrored family.
        assert_allclose(full @ basis.T, basis.T @ block, rtol=0, atol=1e-6 * size)
    # The other cells' columns follow from those of cell 0.
    assert_allclose(matrix[1, :, 1], matrix[0, :, 0], rtol=0, atol=0)


def test_couplings_are_the_blocks_of_the_full_matrix(
    matrix: np.ndarray, blocks: dict[int, np.ndarray]
) -> None:
    """The paper zeroes blocks of the matrix of all cells: the same thing."""
    basis = azimuthal_basis(TRAIN.degree, 1).reshape(-1, matrix.shape[1])
    found = couplings(blocks[1], CELLS)
    size = np.abs(matrix).max()
    # What the first cell feels of the cell p places ahead.
    for ahead in range(CELLS):
        expected = basis @ matrix[0, :, ahead] @ basis.T
        assert_allclose(found[ahead], expected, rtol=0, atol=1e-6 * size)


def test_the_growth_rate_is_that_of_the_full_matrix(base: Base, matrix: np.ndarray) -> None:
    size = CELLS * base.coefficients.size
    eigenvalues = np.linalg.eigvals(matrix.reshape(size, size))
    leading = stability(base, estimate_error=False).leading
    value = complex(leading.growth_rate, leading.frequency)
    assert np.abs(eigenvalues - value).min() < 1e-5 * abs(value) + 1e-6


def test_differences_approach_the_exact_matrix(base: Base, matrix: np.ndarray) -> None:
    # A few of the columns; the differences are one-sided, as the paper's.
    size = base.coefficients.size
    shapes = jnp.asarray(place_cells(base.coefficients, TRAIN, CELLS))
    chosen = [1, 3, 40, 41, 75, 78]
    directions = jnp.eye(size)[jnp.array(chosen)].reshape(-1, *base.coefficients.shape)
    exact = matrix[:, :, 0][:, :, chosen]

    def error(step: float) -> float:
        columns = FiniteDifference(step).columns(matrix_operator(base), shapes, directions, 1)
        found = np.asarray(columns).reshape(len(chosen), CELLS, size)
        return float(np.abs(found.transpose(1, 2, 0) - exact).max())

    errors = error(1e-2), error(1e-3)
    assert np.log10(errors[0] / errors[1]) == pytest.approx(1, abs=0.1)
    assert errors[1] < 1e-2 * np.abs(exact).max()


def test_opposite_waves_are_conjugate(base: Base) -> None:
    forth, back = (linear_blocks(base, [q], NUMBERS) for q in (1.3, -1.3))
    for m in NUMBERS:
        size = np.abs(forth[m]).max()
        assert_allclose(back[m], forth[m].conj(), rtol=0, atol=1e-12 * size)
        assert m > 2 or np.abs(forth[m].imag).max() > 1e-3 * size
