"""Steady trains beside the operator for any shapes, which knows nothing of meridians."""

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain import Base, CaseError, fluid_velocity
from celltrain.harmonics import real_harmonics
from celltrain.membrane import place_cells
from celltrain.meridian.rules import Rules, choose_rules
from celltrain.steady.iterate import newton
from celltrain.steady.problem import SteadyProblem
from celltrain.steady.solve import describe
from celltrain.train import CellsOperator, train_operator


class Exact(SteadyProblem):
    """With rules that leave next to nothing."""

    def rules(self, profile: np.ndarray) -> Rules:
        return choose_rules(
            profile,
            period=self.train.period,
            radius=self.train.radius,
            targets=self.train.sizes.target_order,
            tolerance=1e-10,
            radial=60,
            around=60,
        )


@pytest.mark.slow
def test_all_its_cells_move_rigidly(coarse_base: Base) -> None:
    # Not on one meridian, not alone in a period, as the steady equations have it.
    train = coarse_base.train.changed(
        source_order=32, polar_radial=54, polar_azimuthal=68, near_cutoff=2.0, tolerance=1e-9
    )
    problem = Exact(train)
    found = newton(problem, coarse_base.profile, tolerance=1e-9, most=10)
    assert found.steady
    base = describe(problem, found, "with next to exact rules")
    operator = train_operator(train, cells=train.cells)
    shapes = jnp.asarray(place_cells(base.coefficients, train, train.cells))

    @eqx.filter_jit
    def velocity(operator: CellsOperator, shapes: jax.Array) -> tuple[jax.Array, jax.Array]:
        forces, targets = operator.forces(shapes), operator.targets(shapes)
        total = operator.own_velocity(targets, shapes, forces)
        total = total + operator.outer_velocity(targets, shapes, forces)
        rates = operator.conserve_volume(shapes, operator.project(total))
        return total, jnp.einsum("pk,cik->cpi", operator.target_grid.values, rates)

    before, after = velocity(operator, shapes)
    rigid = np.array([0.0, 0.0, base.cell_velocity])
    assert_allclose(np.linalg.norm(after - rigid, axis=-1), 0.0, atol=1e-7)
    deviation = np.linalg.norm(before - rigid, axis=-1).max()
    assert deviation > 1e-3
    assert_allclose(deviation, base.truncation_error, rtol=1e-4)


def test_fluid_of_a_steady_train(coarse_base: Base) -> None:
    base = replace(coarse_base, train=coarse_base.train.changed(source_order=24))
    period, radius = base.train.period, base.train.radius
    # Inside a cell, halfway between the membrane and a point on the axis, all moves along.
    theta, phi = np.array([0.5, 1.2, 1.7, 2.6]), np.array([0.1, 2.0, 4.0, 5.0])
    membrane = real_harmonics(6, theta, phi) @ base.coefficients.T
    poles = real_harmonics(6, np.array([0.0, np.pi]), np.zeros(2)) @ base.coefficients.T
    inside = 0.5 * (membrane + poles.mean(axis=0))
    on_the_wall = (
        (1 - 1e-12) * radius * np.stack([np.cos(phi), np.sin(phi), theta / radius], axis=-1)
    )
    nodes, weights = np.polynomial.legendre.leggauss(8)
    square = 0.5 * (nodes + 1)
    between = radius * np.sqrt(square)[:, None] * [0.8, 0.6, 0.0] + [0.0, 0.0, 0.5 * period]
    points = np.concatenate([inside, on_the_wall, between])

    found = fluid_velocity(base, points)
    in_cell, at_wall, in_section = np.split(found, [4, 8])
    rigid = np.broadcast_to([0.0, 0.0, base.cell_velocity], in_cell.shape)
    assert_allclose(in_cell, rigid, rtol=0, atol=2 * base.truncation_error)
    assert_allclose(at_wall, 0.0, atol=1e-5)
    # The flow rate is that of the unit of velocity.
    assert_allclose(0.5 * weights @ in_section[:, 2], 1.0, rtol=0, atol=1e-5)
    assert np.abs(in_section[:, 2] - 2 * (1 - square)).max() > 0.01
    moved = fluid_velocity(base, points + np.array([0.0, 0.0, 2 * period]))
    assert_allclose(moved, found, rtol=0, atol=1e-10)
    with pytest.raises(CaseError, match=r"0\.01 r0 beyond .* radius is 3"):
        fluid_velocity(base, np.array([[0.0, 3.01, 0.0]]))
