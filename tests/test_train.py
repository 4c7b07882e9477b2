"""The rates of change of a train's shapes: two different cells, deformed, in one period."""

from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain import Train
from celltrain.harmonics import UNIT_DISPLACEMENT, axisymmetric_basis, azimuthal_basis, profile_of
from celltrain.membrane import place_cells
from celltrain.meridian.rules import choose_rules
from celltrain.steady.problem import SteadyProblem
from celltrain.train import CellsOperator, resting_shapes, train_operator

DEGREE, CELLS = 6, 2
TRAIN = Train(
    diameter=6,
    packing=0.4,
    cells=CELLS,
    degree=DEGREE,
    source_order=16,
    polar_radial=20,
    polar_azimuthal=28,
    tolerance=1e-9,
)
Rates = Callable[[CellsOperator, np.ndarray], np.ndarray]


@pytest.fixture(scope="module")
def rates() -> Rates:
    compiled = eqx.filter_jit(lambda operator, shapes: operator.rates(shapes))
    return lambda operator, shapes: np.asarray(compiled(operator, jnp.asarray(shapes)))


@pytest.fixture(scope="module")
def any_shapes() -> CellsOperator:
    # The rule for close cells, which these do not need, takes long to compile.
    return train_operator(TRAIN, cells=CELLS, close=False)


@pytest.fixture(scope="module")
def axisymmetric() -> np.ndarray:
    """Two different axisymmetric cells, deformed by a few hundredths."""
    basis = axisymmetric_basis(DEGREE)
    amounts = 0.05 * np.random.default_rng(0).normal(size=(CELLS, len(basis)))
    return resting_shapes(TRAIN, CELLS) + np.einsum("cu,uik->cik", amounts, basis)


@pytest.fixture(scope="module")
def skewed(axisymmetric: np.ndarray) -> np.ndarray:
    """The same off the axis and without any symmetry."""
    return axisymmetric + 0.05 * np.random.default_rng(1).normal(size=axisymmetric.shape)


def soft(operator: CellsOperator) -> CellsOperator:
    """The same train of cells without any elasticity."""
    membrane = operator.membrane
    return eqx.tree_at(
        lambda o: (
            o.membrane.law.shear_modulus,
            o.membrane.law.dilatation_modulus,
            o.membrane.bending.bending_modulus,
        ),
        operator,
        [0.0 * membrane.bending.bending_modulus] * 3,
    )


def test_train_at_rest_is_carried_by_the_flow_alone(
    any_shapes: CellsOperator, rates: Rates
) -> None:
    resting = resting_shapes(TRAIN, CELLS)
    grid = any_shapes.target_grid
    x, y, _ = np.moveaxis(resting @ np.asarray(grid.values).T, 1, 0)
    profile = 2 * (1 - (x**2 + y**2) / 9)
    expected = np.zeros_like(resting)
    expected[:, 2] = profile @ np.asarray(grid.projection).T
    found = rates(any_shapes, resting)
    assert_allclose(found, expected, rtol=0, atol=1e-11)
    assert_allclose(found, rates(soft(any_shapes), resting), rtol=0, atol=1e-11)


def test_two_operators_agree(rates: Rates) -> None:
    """On axisymmetric cells, all alike, whose velocity the meridian gives by another way."""
    train = TRAIN.changed(
        cells=1, source_order=32, polar_radial=54, polar_azimuthal=68, near_cutoff=2.0
    )
    basis = axisymmetric_basis(DEGREE)
    amounts = 0.05 * np.random.default_rng(0).normal(size=len(basis))
    shapes = resting_shapes(train, 1) + np.einsum("u,uik->ik", amounts, basis)
    found = rates(train_operator(train, cells=1, close=False), shapes)[0]
    profile = profile_of(shapes[0])
    rules = choose_rules(
        profile,
        period=train.period,
        radius=train.radius,
        targets=train.sizes.target_order,
        tolerance=1e-10,
        radial=60,
        around=60,
    )
    expected = SteadyProblem(train).flow(profile, rules).rates
    members = azimuthal_basis(DEGREE, 0)
    assert_allclose(found, np.einsum("u,uik->ik", expected, members), rtol=0, atol=2e-8)


def test_derivative_of_the_rates(
    skewed: np.ndarray, any_shapes: CellsOperator, rates: Rates
) -> None:
    step = np.random.default_rng(2).normal(size=skewed.shape)
    step /= np.linalg.norm(step)

    @eqx.filter_jit
    def change(operator: CellsOperator, shapes: jax.Array, step: jax.Array) -> jax.Array:
        return jax.jvp(operator.rates, (shapes,), (step,))[1]

    exact = np.asarray(change(any_shapes, jnp.asarray(skewed), jnp.asarray(step)))

    def error(h: float) -> float:
        ahead, behind = (rates(any_shapes, skewed + sign * h * step) for sign in (1, -1))
        return float(np.abs((ahead - behind) / (2 * h) - exact).max() / np.abs(exact).max())

    assert np.log10(error(1e-2) / error(1e-3)) == pytest.approx(2, abs=0.1)
    assert error(1e-4) < 1e-7


def test_turned_and_mirrored_trains_move_alike(
    skewed: np.ndarray, any_shapes: CellsOperator, rates: Rates
) -> None:
    expected = rates(any_shapes, skewed)
    cosine, sine = np.cos(0.7), np.sin(0.7)
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    assert_allclose(rates(any_shapes, turn @ skewed), turn @ expected, rtol=0, atol=2e-8)
    # A mirror image of a closed surface in its outward order: mirrored in longitude, too.
    order = np.arange(DEGREE**2) - np.repeat(
        [n * n + n for n in range(DEGREE)], 2 * np.arange(DEGREE) + 1
    )
    mirror = np.diag([1.0, -1.0, 1.0]) @ (skewed * np.where(order < 0, -1.0, 1.0))
    found = np.diag([1.0, -1.0, 1.0]) @ rates(any_shapes, mirror) * np.where(order < 0, -1.0, 1.0)
    assert_allclose(found, expected, rtol=0, atol=2e-8)


def test_shifted_train_moves_alike(
    skewed: np.ndarray, any_shapes: CellsOperator, rates: Rates
) -> None:
    # By any distance; and the second cell by a period of all, which makes it the first.
    shifted = skewed.copy()
    shifted[:, 2, 0] += 0.777
    shifted[1, 2, 0] -= CELLS * TRAIN.period * UNIT_DISPLACEMENT
    found = rates(any_shapes, shifted[::-1])[::-1]
    assert_allclose(found, rates(any_shapes, skewed), rtol=0, atol=2e-8)


def test_copies_of_a_cell_move_as_it_does_alone_in_its_period(
    axisymmetric: np.ndarray, any_shapes: CellsOperator, rates: Rates
) -> None:
    alone = rates(train_operator(TRAIN, cells=1, close=False), axisymmetric[:1])
    together = rates(any_shapes, place_cells(axisymmetric[0], TRAIN, CELLS))
    assert_allclose(together, np.repeat(alone, CELLS, axis=0), rtol=0, atol=2e-8)


def test_shapes_that_are_no_numbers_have_rates_that_are_none(
    skewed: np.ndarray, any_shapes: CellsOperator, rates: Rates
) -> None:
    for wrong in (np.nan, np.inf):
        shapes = skewed.copy()
        shapes[0, 1, 2] = wrong
        assert np.isnan(rates(any_shapes, shapes)).all()


def test_volume_is_conserved_exactly(
    skewed: np.ndarray, any_shapes: CellsOperator, rates: Rates
) -> None:
    gradient = np.asarray(jax.vmap(any_shapes.membrane.volume_gradient)(jnp.asarray(skewed)))
    found = rates(any_shapes, skewed)
    drift = np.sum(gradient * found, axis=(1, 2))
    assert_allclose(drift, 0.0, atol=1e-13 * np.linalg.norm(gradient) * np.linalg.norm(found))


def test_the_programs_of_users_give_what_those_of_tests_give(
    any_shapes: CellsOperator, skewed: np.ndarray, rates: Rates
) -> None:
    """Compiled with the optimisations that `conftest` switches off."""
    arrays, rest = eqx.partition(any_shapes, eqx.is_array)
    optimised = jax.jit(
        lambda arrays, shapes: eqx.combine(arrays, rest).rates(shapes),
        compiler_options={
            "xla_backend_optimization_level": 3,
            "xla_llvm_disable_expensive_passes": False,
        },
    )
    found, expected = np.asarray(optimised(arrays, jnp.asarray(skewed))), rates(any_shapes, skewed)
    assert_allclose(found, expected, rtol=0, atol=1e-13 * np.abs(expected).max())
    # Another program, all the same.
    assert not np.array_equal(found, expected)


@pytest.mark.parametrize("seed", range(3))
def test_energy_is_only_lost_without_flow(
    seed: int, axisymmetric: np.ndarray, any_shapes: CellsOperator, rates: Rates
) -> None:
    shapes = axisymmetric + 0.05 * np.random.default_rng(seed).normal(size=axisymmetric.shape)
    forces = np.asarray(any_shapes.forces(jnp.asarray(shapes)))
    # Velocity by the forces alone.
    response = rates(any_shapes, shapes) - rates(soft(any_shapes), shapes)
    power = np.sum(forces * response)
    assert power > 0.1 * np.linalg.norm(forces) * np.linalg.norm(response)


@pytest.mark.parametrize("m", range(DEGREE + 1))
def test_disturbances_of_one_azimuthal_number_turn_into_themselves(m: int) -> None:
    basis = azimuthal_basis(DEGREE, m)
    flat = basis.reshape(len(basis), -1)
    assert_allclose(flat @ flat.T, np.eye(len(flat)), rtol=0, atol=1e-14)
    others = [azimuthal_basis(DEGREE, k).reshape(-1, flat.shape[1]) for k in range(DEGREE + 1)]
    for k, other in enumerate(others):
        if k != m:
            assert_allclose(flat @ other.T, 0.0, atol=1e-14)
