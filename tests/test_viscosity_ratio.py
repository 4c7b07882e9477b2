"""Cells of another viscosity than the plasma's: limits, identities, derivatives."""

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain import Train
from celltrain.harmonics import UNIT_DISPLACEMENT, azimuthal_basis
from celltrain.membrane import place_cells
from celltrain.stability import linear_blocks
from celltrain.steady import Base, steady
from celltrain.steady.problem import SteadyProblem
from celltrain.train import CellsOperator, resting_shapes, train_operator

DEGREE, CELLS = 6, 2
# All cases but the spheres share their programs. So fine that blocks agree with them to 2e-5.
TRAIN = Train(
    diameter=5,
    packing=0.3,
    cells=CELLS,
    degree=DEGREE,
    source_order=22,
    polar_radial=38,
    polar_azimuthal=46,
    tolerance=1e-8,
)


@eqx.filter_jit
def rates(operator: CellsOperator, shapes: jax.Array) -> jax.Array:
    return operator.rates(shapes)


@eqx.filter_jit
def derivative(operator: CellsOperator, shapes: jax.Array, step: jax.Array) -> jax.Array:
    return jax.jvp(operator.rates, (shapes,), (step,))[1]


@eqx.filter_jit
def speed_and_viscosity(operator: CellsOperator, shapes: jax.Array) -> tuple[jax.Array, jax.Array]:
    motions = operator.rates(shapes)
    speed = jnp.mean(motions[:, 2, 0]) / UNIT_DISPLACEMENT
    return speed, operator.effective_viscosity(shapes, operator.forces(shapes), motions)


def of_ratio(operator: CellsOperator, ratio: float) -> CellsOperator:
    return eqx.tree_at(lambda each: each.viscosity_ratio, operator, jnp.asarray(ratio))


@pytest.fixture(scope="module")
def operator() -> CellsOperator:
    return train_operator(TRAIN.changed(viscosity_ratio=5.0), cells=CELLS)


@pytest.fixture(scope="module")
def skewed() -> np.ndarray:
    """Two different cells off the axis, without any symmetry."""
    random = np.random.default_rng(1)
    low = np.arange(DEGREE**2) < 16
    shapes = resting_shapes(TRAIN, CELLS) + 0.04 * low * random.normal(size=(CELLS, 3, low.size))
    shapes[:, :2, 0] += 0.4 * random.normal(size=(CELLS, 2))
    return shapes


@pytest.mark.slow
def test_ratio_one_is_the_limit(operator: CellsOperator, skewed: np.ndarray) -> None:
    shapes = jnp.asarray(skewed)
    expected = rates(train_operator(TRAIN, cells=CELLS), shapes)
    steps = np.array([1e-2, 1e-3])
    errors = [
        np.abs(0.5 * (rates(of_ratio(operator, 1 + h), shapes) + rates(
            of_ratio(operator, 1 - h), shapes)) - expected).max()
        for h in steps
    ]  # fmt: skip
    # Second order in the difference from 1: no jump there.
    assert errors[0] / errors[1] > 60


@pytest.mark.parametrize("ratio", [0.01, 0.2, 30.0, 1000.0])
def test_volume_stays_at_any_ratio(
    operator: CellsOperator, skewed: np.ndarray, ratio: float
) -> None:
    shapes = jnp.asarray(skewed)
    found = rates(of_ratio(operator, ratio), shapes)
    gradient = jax.vmap(operator.membrane.volume_gradient)(shapes)
    assert_allclose(jnp.sum(gradient * found, axis=(1, 2)), 0.0, atol=1e-9)
    # Forces and flow of the same size whatever the ratio.
    assert 0.5 < float(jnp.abs(found).max()) < 50


def test_hard_cells_move_rigidly(operator: CellsOperator, skewed: np.ndarray) -> None:
    shapes = jnp.asarray(skewed)
    interior = eqx.filter_jit(lambda o, s: o.interior_flow(s))(operator, shapes)

    def deformation(ratio: float) -> float:
        found = rates(of_ratio(operator, ratio), shapes)
        return float(jnp.linalg.norm(found - interior.rigid_part(found)))

    assert_allclose(deformation(1e4) / deformation(1e3), 0.1, rtol=2e-2)


def test_train_of_rigid_spheres_is_the_limit() -> None:
    """Force-free spheres, a/R = 0.5 and L/R = 2: U/V and the apparent viscosity."""
    train = Train(diameter=4, packing=0.25, reference="sphere", degree=8, tolerance=1e-8)
    operator = train_operator(train.changed(viscosity_ratio=2.0), cells=1)
    shapes = jnp.asarray(resting_shapes(train, 1))
    values = [
        np.array(speed_and_viscosity(of_ratio(operator, ratio), shapes))
        for ratio in (500.0, 1000.0, 2000.0)
    ]
    # Extrapolated in 1/ratio.
    limit = (8 * values[2] - 6 * values[1] + values[0]) / 3
    assert_allclose(limit, [1.6789619, 1.0323471], rtol=2e-7)


@pytest.mark.slow
def test_derivative_of_the_rates(operator: CellsOperator, skewed: np.ndarray) -> None:
    step = np.random.default_rng(2).normal(size=skewed.shape) * (np.arange(DEGREE**2) < 16)
    shapes, along = jnp.asarray(skewed), jnp.asarray(step)
    exact = derivative(operator, shapes, along)

    def error(size: float) -> float:
        ahead, behind = (rates(operator, shapes + h * along) for h in (size, -size))
        return float(jnp.abs((ahead - behind) / (2 * size) - exact).max())

    # Steps that are large against the equation's tolerance.
    assert np.log2(error(2e-2) / error(1e-2)) == pytest.approx(2, abs=0.1)


@pytest.fixture(scope="module")
def viscous_base() -> Base:
    return steady(TRAIN.changed(viscosity_ratio=5.0), estimate_error=False)


def test_steady_train_does_not_depend_on_the_ratio(
    viscous_base: Base, operator: CellsOperator
) -> None:
    other = steady(TRAIN, estimate_error=False)
    assert_allclose(viscous_base.coefficients, other.coefficients, rtol=0, atol=1e-10)
    # It is steady for the dynamics of viscous cells, which know nothing of that.
    shapes = jnp.asarray(place_cells(viscous_base.coefficients, viscous_base.train, CELLS))
    found = rates(operator, shapes)
    found = np.asarray(found.at[:, 2, 0].add(-viscous_base.cell_velocity * UNIT_DISPLACEMENT))
    # By its own rules, which are coarse; the same as for cells of the plasma's viscosity.
    assert_allclose(found, 0.0, atol=1e-3)


@pytest.mark.slow
def test_blocks_are_the_derivative_of_the_rates(
    viscous_base: Base, operator: CellsOperator
) -> None:
    """The meridian's blocks, which never differentiate the double layer, beside the equation's."""
    train = viscous_base.train
    shapes = jnp.asarray(place_cells(viscous_base.coefficients, train, CELLS))
    rules = SteadyProblem(train).rules(viscous_base.profile)
    rules = replace(rules, radial=40, half_circle=25)
    blocks = linear_blocks(viscous_base, [0.0, np.pi], [0, 1, 2], rules=rules)
    for m, wave, column in ((0, 1, 3), (1, 0, 5), (1, 1, 14), (2, 1, 2)):
        basis = azimuthal_basis(train.degree, m)
        sign = np.array([1.0, -1.0 if wave else 1.0])[:, None, None]
        found = derivative(operator, shapes, jnp.asarray(sign * basis[column]))[0]
        expected = blocks[m][wave][:, column]
        assert_allclose(np.einsum("uik,ik->u", basis, found), expected, rtol=0, atol=2e-5)
        assert np.abs(expected).max() > 0.1
