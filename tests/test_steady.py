"""Steady trains: that they are steady, and that there are several ways to them."""

from dataclasses import replace
from itertools import pairwise

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain import Base, CaseError, NotConverged, steady
from celltrain.harmonics import real_harmonics
from celltrain.steady import Iteration, change_degree, fluid_velocity
from celltrain.train import (
    TrainOperator,
    largest_radius,
    place_cells,
    streamwise_gap,
    train_membrane,
    train_operator,
)


def test_steady_train_is_steady(coarse_base: Base) -> None:
    assert coarse_base.residual < 1e-9
    membrane = train_membrane(coarse_base.train)
    held = membrane.volume(jnp.asarray(coarse_base.coefficients))
    assert_allclose(held, membrane.volume(membrane.reference_shape), rtol=0, atol=1e-9)
    # Its mean point is at the origin.
    assert_allclose(coarse_base.coefficients[:, 0], 0.0, atol=1e-12)


def test_all_its_cells_move_rigidly(coarse_base: Base) -> None:
    # Not on one meridian, not alone in a period, as the steady equations have it.
    train = coarse_base.train
    operator = train_operator(train, cells=train.cells)
    shapes = jnp.asarray(place_cells(coarse_base.coefficients, train, train.cells))

    @eqx.filter_jit
    def velocity(operator: TrainOperator, shapes: jax.Array) -> tuple[jax.Array, jax.Array]:
        forces, targets = operator.forces(shapes), operator.targets(shapes)
        total = operator.own_velocity(targets, shapes, forces)
        total = total + operator.outer_velocity(targets, shapes, forces)
        rates = operator.conserve_volume(shapes, operator.project(total))
        return total, jnp.einsum("pk,cik->cpi", operator.target_grid.values, rates)

    before, after = velocity(operator, shapes)
    rigid = np.array([0.0, 0.0, coarse_base.cell_velocity])
    assert_allclose(np.linalg.norm(after - rigid, axis=-1), 0.0, atol=1e-7)
    deviation = np.linalg.norm(before - rigid, axis=-1).max()
    assert deviation > 1e-3
    assert_allclose(deviation, coarse_base.truncation_error, rtol=1e-4)


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
    with pytest.raises(CaseError, match=r"distance 3.01 .* radius is 3"):
        fluid_velocity(base, np.array([[0.0, 3.01, 0.0]]))


def test_what_is_told_of_it(coarse_base: Base) -> None:
    # Faster than the mean flow, slower than the flow on the axis.
    assert 1.0 < coarse_base.cell_velocity < 2.0
    assert 1.0 < coarse_base.effective_viscosity < 2.0
    assert coarse_base.largest_radius == largest_radius(coarse_base.coefficients)
    assert coarse_base.gap == streamwise_gap(coarse_base.coefficients, 1 / 0.3)
    assert coarse_base.origin == "march from the resting shape"
    assert set(coarse_base.seconds) == {"compile", "base"}
    methods = [step.method for step in coarse_base.history]
    assert methods[0] == "march"
    assert methods[-1] == "newton"
    # Newton's method squares the residual, until roundoff.
    residuals = [step.residual for step in coarse_base.history if step.method == "newton"]
    assert any(after < 20 * before**2 for before, after in pairwise(residuals))


def test_continuation_and_march_lead_to_the_same_train(coarse_base: Base) -> None:
    seen: list[Iteration] = []
    nearby = steady(coarse_base.train.changed(packing=0.29), progress=seen.append)
    assert tuple(seen) == nearby.history
    assert abs(nearby.cell_velocity - coarse_base.cell_velocity) > 1e-4
    # The number of cells does not matter.
    followed = steady(coarse_base.train.changed(cells=1), start=nearby)
    assert {step.method for step in followed.history} == {"newton"}
    assert_allclose(followed.coefficients, coarse_base.coefficients, rtol=0, atol=1e-8)
    assert_allclose(followed.cell_velocity, coarse_base.cell_velocity, rtol=0, atol=1e-9)
    assert "packing = 0.29" in followed.origin
    assert "cells = 3" in followed.origin


def test_start_from_the_solution_is_the_solution(coarse_base: Base) -> None:
    again = steady(coarse_base.train, start=coarse_base)
    assert again.history == ()
    assert_allclose(again.coefficients, coarse_base.coefficients, rtol=0, atol=1e-14)


def test_a_march_that_is_cut_short_says_so(coarse_base: Base) -> None:
    with pytest.raises(NotConverged, match="2 iterations") as failure:
        steady(coarse_base.train, max_iterations=2)
    last = failure.value.last
    assert len(last.history) == 2
    assert failure.value.history == last.history == coarse_base.history[:2]
    assert last.residual > 1e-3
    assert f"{last.residual:.2e}" in str(failure.value)
    # And it is a way to go on.
    followed = steady(coarse_base.train, start=last)
    assert_allclose(followed.coefficients, coarse_base.coefficients, rtol=0, atol=1e-8)


def test_change_of_degree() -> None:
    shape = np.random.default_rng(0).normal(size=(3, 36))
    finer = change_degree(shape, 8)
    theta, phi = np.array([0.4, 2.0]), np.array([1.0, 5.0])
    expected = real_harmonics(6, theta, phi) @ shape.T
    assert_allclose(real_harmonics(8, theta, phi) @ finer.T, expected, rtol=0, atol=1e-14)
    assert_allclose(change_degree(finer, 6), shape, rtol=0, atol=0)
