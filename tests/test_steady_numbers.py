"""Numbers of steady trains and their growth rates, known to many digits."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain import Base, Train, steady
from celltrain.stability.linearise import linear_blocks
from celltrain.stability.neutral import neutral_space
from celltrain.stability.spectrum import growing_eigenvalues

CELLS = 8
NUMBERS = (0, 1, 2, 3)

AtDegree = Callable[[float, int], Base]


def growth_rate(base: Base) -> float:
    """alpha, of four azimuthal numbers."""
    waves = range(CELLS // 2 + 1)
    phases = [2 * np.pi * j / CELLS for j in waves]
    blocks = linear_blocks(base, phases, NUMBERS)
    return max(
        float(growing_eigenvalues(blocks[m][j], neutral_space(base, m, j))[0].real)
        for m in NUMBERS
        for j in waves
    )


@pytest.fixture(scope="module")
def at_degree() -> AtDegree:
    """Steady trains of packing 0.2, each from the one of the degree before."""
    known: dict[float, Base] = {}

    def make(diameter: float, degree: int) -> Base:
        train = Train(diameter=diameter, packing=0.2, cells=CELLS, degree=degree)
        known[diameter] = steady(train, start=known.get(diameter), estimate_error=False)
        return known[diameter]

    return make


@pytest.mark.parametrize(
    ("degree", "velocity", "growth"),
    [
        (12, 1.771955, 0.011784),
        (16, 1.774960, 0.014173),
        (20, 1.775435, 0.013877),
        (24, 1.775493, 0.013820),
    ],
)
def test_wide_tube(degree: int, velocity: float, growth: float, at_degree: AtDegree) -> None:
    base = at_degree(6.0, degree)
    assert base.residual < 1e-9
    assert_allclose(base.cell_velocity, velocity, rtol=0, atol=6e-7)
    assert_allclose(growth_rate(base), growth, rtol=0, atol=6e-7)


@pytest.mark.parametrize(
    ("degree", "growth"), [(12, 0.0364), (16, 0.0328), (20, 0.0302), (24, 0.0280)]
)
def test_narrow_tube(degree: int, growth: float, at_degree: AtDegree) -> None:
    base = at_degree(3.0, degree)
    assert base.residual < 1e-9
    assert_allclose(growth_rate(base), growth, rtol=0, atol=6e-5)


@pytest.mark.parametrize(
    ("diameter", "packing"), [(6.0, 0.01), (6.0, 0.05), (6.0, 0.8), (2.8, 0.2), (2.4, 0.2)]
)
def test_trains_that_are_sparse_dense_or_narrow(diameter: float, packing: float) -> None:
    train = Train(diameter=diameter, packing=packing, cells=CELLS, degree=12)
    base = steady(train, estimate_error=False)
    assert base.residual < 1e-9
    assert base.gap > 0.0
    assert base.largest_radius < 0.5 * diameter
    assert base.effective_viscosity > 1.0
    # Cells near the axis go faster than the flow does on average, slower than at its fastest.
    assert 1.0 < base.cell_velocity < 2.0
