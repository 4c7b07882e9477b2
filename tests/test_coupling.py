"""What the cells of a steady train give each other, on the meridian and by the operator in JAX."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain import CaseError, Train, steady
from celltrain.evolution import Repulsion, dynamics
from celltrain.train import CellsOperator, Coupling, train_coupling, train_operator
from celltrain.train.gmres import Iterations
from celltrain.train.interior import _by_cell

TRAIN = Train(diameter=5, packing=0.4, cells=3, degree=8, viscosity_ratio=5.0)


@pytest.fixture(scope="module")
def coupling() -> Coupling:
    return train_coupling(steady(TRAIN))


@pytest.fixture(scope="module")
def operator() -> CellsOperator:
    return train_operator(TRAIN, cells=TRAIN.cells)


@eqx.filter_jit
def solved(operator: CellsOperator, shapes: jax.Array) -> tuple[jax.Array, Iterations | None]:
    return operator.solved_rates(shapes)


@pytest.mark.parametrize(
    ("finer", "tolerance"), [({}, 4e-4), ({"target_order": 20, "source_order": 40}, 8e-5)]
)
def test_it_is_what_lies_beside_the_own_surfaces(finer: dict[str, int], tolerance: float) -> None:
    """Of all motions without a rigid part that keep the volumes: two independent operators."""
    train = TRAIN.changed(**finer)
    coupling = train_coupling(steady(train))
    operator = train_operator(train, cells=train.cells)

    @eqx.filter_jit
    def both(operator: CellsOperator, motions: jax.Array) -> tuple[jax.Array, jax.Array]:
        interior = operator.interior_flow(coupling.steady)
        rest = interior.without_inflation(motions - interior.rigid_part(motions))
        own = _by_cell(interior.free, rest) - 0.5 * interior.rigid_part(motions)
        whole = interior.apply(operator.outer_motion(coupling.steady), motions)
        return whole - interior.without_inflation(own), coupling(rest)

    random = np.random.default_rng(0)
    motions = jnp.asarray(random.normal(size=coupling.steady.shape))
    expected, found = both(operator, motions)
    assert np.linalg.norm(found) > 0.2
    assert_allclose(found, expected, rtol=0, atol=tolerance * np.linalg.norm(found))


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [0.01, 5.0, 1000.0])
def test_it_saves_iterations_and_changes_nothing(
    ratio: float, operator: CellsOperator, coupling: Coupling
) -> None:
    operator = eqx.tree_at(lambda each: each.viscosity_ratio, operator, jnp.asarray(ratio))
    better = dataclasses.replace(operator, coupling=coupling)
    exact = dataclasses.replace(operator, solver_tolerance=1e-4 * operator.solver_tolerance)
    random = np.random.default_rng(1)
    low = np.arange(TRAIN.degree**2) < 16
    change = jnp.asarray(random.normal(size=coupling.steady.shape) * low)
    saved = 0
    for size in (0.003, 0.02, 0.12):
        shapes = coupling.steady + size * change
        expected, convergence = solved(exact, shapes)
        assert convergence is not None
        assert convergence.residual <= exact.solver_tolerance
        largest = 4.0 * operator.solver_tolerance * np.linalg.norm(expected)
        counts = []
        for each in (operator, better):
            found, convergence = solved(each, shapes)
            assert convergence is not None
            assert_allclose(found, expected, rtol=0, atol=largest)
            counts.append(int(convergence.iterations))
        without, within = counts
        assert within < without if coupling.serves(shapes) else within == without
        saved += without - within
    assert saved > 2


def test_far_from_the_steady_train_it_is_not_used(coupling: Coupling) -> None:
    # One cell of three.
    moved = coupling.steady.at[1, 0, 0].add(0.21 * np.sqrt(4.0 * np.pi))
    assert coupling.serves(coupling.steady)
    assert not coupling.serves(moved)
    # The whole train may be anywhere along the tube.
    assert coupling.serves(coupling.steady.at[:, 2, 0].add(5.0))
    with pytest.raises(ValueError, match="of a train with"):
        coupling.serves(coupling.steady[:1])
    with pytest.raises(CaseError, match="such cells need no coupling"):
        train_coupling(steady(TRAIN.changed(viscosity_ratio=1.0)))
    nearer = coupling.steady.at[1, 0, 0].add(0.19 * np.sqrt(4.0 * np.pi))
    assert coupling.serves(nearer)


def test_the_dynamics_of_a_train_has_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Made once; of a train without another viscosity there is none."""
    # What would compile programs.
    monkeypatch.setattr(dynamics, "_tube_rates", lambda _, shapes, forces: np.asarray(shapes))
    monkeypatch.setattr(dynamics, "cell_volumes", lambda _, shapes: shapes[:, 0, 0])
    first = dynamics.train_dynamics(steady(TRAIN), Repulsion(), wall_gap=0.8)
    assert isinstance(first.operator.coupling, Coupling)
    monkeypatch.setattr(dynamics, "train_coupling", None)
    second = dynamics.train_dynamics(steady(TRAIN), Repulsion(), wall_gap=0.4, known=first)
    assert second.operator.coupling is first.operator.coupling
    assert second.linear_part is first.linear_part
    alike = steady(TRAIN.changed(viscosity_ratio=1.0))
    third = dynamics.train_dynamics(alike, Repulsion(), wall_gap=0.8)
    assert third.operator.coupling is None
