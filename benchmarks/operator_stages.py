"""The velocity of cells of any shape, a stage a process: ``operator_stages.py NAME RUNS``.

Prints one JSON object (see `measuring.measure`); results are waited for. The first call takes
tracing, compiling or loading from the cache.
"""

import sys
from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from measuring import Work, run_stage

from celltrain import Train, steady
from celltrain.flow import Sources
from celltrain.membrane import place_cells
from celltrain.train import CellsOperator, resting_shapes, train_coupling, train_operator

TRAIN = Train(diameter=6, packing=0.2, cells=8, degree=12)
# Size of the disturbance (r0) that makes the shapes of the train different from each other.
DISTURBANCE = 0.01
RATIOS = (0.01, 0.1, 0.5, 2.0, 5.0, 20.0, 100.0, 1000.0)


def _waited(compiled: Callable[..., Any], *inputs: Any) -> Work:
    return lambda: jax.block_until_ready(compiled(*inputs))


def _disturbed() -> jax.Array:
    """The steady train, every cell disturbed in its lower harmonics."""
    shapes = place_cells(steady(TRAIN).coefficients, TRAIN, TRAIN.cells)
    random = np.random.default_rng(0)
    low = np.arange(shapes.shape[-1]) < 49
    return jnp.asarray(shapes + DISTURBANCE * random.normal(size=shapes.shape) * low)


def _evaluation(part: Callable[..., Any], *prepare: Callable[..., Any]) -> Work:
    """A compiled part of one velocity evaluation; `prepare` makes its inputs from the shapes."""
    operator = train_operator(TRAIN, cells=TRAIN.cells)
    shapes = _disturbed()
    compiled = eqx.filter_jit(part)
    inputs = jax.block_until_ready([eqx.filter_jit(each)(operator, shapes) for each in prepare])
    return _waited(compiled, operator, *(inputs or [shapes]))


def _forces(operator: CellsOperator, shapes: jax.Array) -> jax.Array:
    return operator.forces(shapes)


def _shapes(operator: CellsOperator, shapes: jax.Array) -> jax.Array:
    return shapes


def _targets(operator: CellsOperator, shapes: jax.Array) -> jax.Array:
    return operator.targets(shapes)


def _loose_targets(operator: CellsOperator, shapes: jax.Array) -> jax.Array:
    return operator.targets(shapes).reshape(-1, 3)


def _sources(operator: CellsOperator, shapes: jax.Array) -> Sources:
    return operator.sources(shapes, operator.forces(shapes))


def _analyse(operator: CellsOperator, sources: Sources) -> jax.Array:
    return operator.flow._far_modes(sources)


def _modes(operator: CellsOperator, shapes: jax.Array) -> jax.Array:
    return _analyse(operator, _sources(operator, shapes))


def _synthesise(operator: CellsOperator, targets: jax.Array, modes: jax.Array) -> jax.Array:
    return operator.flow.transform.synthesise(targets, modes)


def _far_at_wall(operator: CellsOperator, modes: jax.Array) -> jax.Array:
    return operator.flow.wall_synthesis.fields(modes)


def _near_wall(operator: CellsOperator, sources: Sources) -> jax.Array:
    # The tube's own way, so that the same work is measured.
    strips, _ = operator.flow.wall.strips()
    points = operator.flow.wall.points().reshape(-1, 3)[strips]
    return operator.flow.near.velocity(points, jnp.full(len(strips), -1), sources, None)


def _near_cells(operator: CellsOperator, targets: jax.Array, sources: Sources) -> jax.Array:
    cells = sources.cells
    groups = targets.reshape(cells, -1, 3)
    return operator.flow.near.velocity(groups, jnp.arange(cells), sources, None)


def _wall_velocity(operator: CellsOperator, shapes: jax.Array) -> jax.Array:
    points = operator.flow.wall.points()
    random = np.random.default_rng(1)
    return jnp.asarray(random.normal(size=points.shape))


def _wall_flow(operator: CellsOperator, targets: jax.Array, boundary: jax.Array) -> jax.Array:
    wall = operator.flow.wall
    return wall.velocity(targets, wall.regular_flow(boundary))


def _viscous(ratio: float) -> Work:
    """The evaluation at another viscosity ratio; says how many iterations each ratio takes."""
    train = TRAIN.changed(viscosity_ratio=ratio)
    operator = train_operator(train, cells=train.cells, coupling=train_coupling(steady(train)))
    shapes = _disturbed()
    compiled = eqx.filter_jit(lambda operator, shapes: operator.solved_rates(shapes))
    for each in RATIOS:
        other = eqx.tree_at(lambda o: o.viscosity_ratio, operator, jnp.asarray(each))
        count = int(compiled(other, shapes)[1].iterations)
        print(f"viscosity ratio {each:g}: {count} iterations", file=sys.stderr)
    return _waited(compiled, operator, shapes)


def _dense(close: bool) -> Work:
    """An evaluation of close cells, off the axis, with and without the rule for them."""
    train = TRAIN.changed(packing=0.7)
    operator = train_operator(train, cells=train.cells, close=close)
    random = np.random.default_rng(0)
    shapes = resting_shapes(train, train.cells)
    shapes[:, :2, 0] += 0.3 * random.normal(size=(train.cells, 2))
    compiled = eqx.filter_jit(lambda operator, shapes: operator.rates(shapes))
    return _waited(compiled, operator, jnp.asarray(shapes))


STAGES: dict[str, Callable[[], Work]] = {
    "evaluation": lambda: _evaluation(lambda operator, shapes: operator.rates(shapes)),
    "evaluation.forces": lambda: _evaluation(_forces),
    "evaluation.own_surface": lambda: _evaluation(
        lambda operator, *inputs: operator.own_velocity(*inputs), _targets, _shapes, _forces
    ),
    "evaluation.far_analyse": lambda: _evaluation(_analyse, _sources),
    "evaluation.far_synthesise": lambda: _evaluation(_synthesise, _loose_targets, _modes),
    "evaluation.far_at_wall": lambda: _evaluation(_far_at_wall, _modes),
    "evaluation.near_wall": lambda: _evaluation(_near_wall, _sources),
    "evaluation.near_cells": lambda: _evaluation(_near_cells, _targets, _sources),
    "evaluation.wall_flow": lambda: _evaluation(_wall_flow, _loose_targets, _wall_velocity),
    "viscous": lambda: _viscous(5.0),
    "dense.ordinary": lambda: _dense(False),
    "dense.close": lambda: _dense(True),
}


if __name__ == "__main__":
    run_stage(STAGES)
