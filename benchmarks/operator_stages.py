"""What is measured, one stage in a process of its own: ``python stages.py NAME RUNS``.

Prints one JSON object: `seconds` (median of the runs, results waited for), `first_seconds` (what
the first call took beyond that: tracing, compiling or loading from the cache), `peak_mib` (largest
resident memory of the process meanwhile, its libraries included).
"""

import contextlib
import json
import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from celltrain import Base, Train, steady
from celltrain.flow import Sources
from celltrain.stability import (
    NORMS,
    block_spectrum,
    infinite_train,
    linear_blocks,
    neutral_space,
    numerical_abscissa,
)
from celltrain.train import TrainOperator, place_cells, resting_shapes, train_operator

TRAIN = Train(diameter=6, packing=0.2, cells=8, degree=12)
AZIMUTHAL_NUMBERS = range(TRAIN.degree + 1)
WAVES = np.arange(TRAIN.cells // 2 + 1)
# Size of the disturbance (r0) that makes the shapes of the train different from each other.
DISTURBANCE = 0.01
RATIOS = (0.01, 0.1, 0.5, 2.0, 5.0, 20.0, 100.0, 1000.0)

Work = Callable[[], Any]


def _base() -> Base:
    return steady(TRAIN)


def _disturbed() -> jax.Array:
    """The steady train, every cell disturbed in its lower harmonics."""
    shapes = place_cells(_base().coefficients, TRAIN, TRAIN.cells)
    random = np.random.default_rng(0)
    low = np.arange(shapes.shape[-1]) < 49
    return jnp.asarray(shapes + DISTURBANCE * random.normal(size=shapes.shape) * low)


def _evaluation(part: Callable[..., Any], *prepare: Callable[..., Any]) -> Work:
    """A compiled part of one velocity evaluation; `prepare` makes its inputs from the shapes."""
    operator = train_operator(TRAIN, cells=TRAIN.cells)
    shapes = _disturbed()
    compiled = eqx.filter_jit(part)
    inputs = jax.block_until_ready([eqx.filter_jit(each)(operator, shapes) for each in prepare])
    return lambda: compiled(operator, *(inputs or [shapes]))


def _forces(operator: TrainOperator, shapes: jax.Array) -> jax.Array:
    return operator.forces(shapes)


def _shapes(operator: TrainOperator, shapes: jax.Array) -> jax.Array:
    return shapes


def _targets(operator: TrainOperator, shapes: jax.Array) -> jax.Array:
    return operator.targets(shapes)


def _loose_targets(operator: TrainOperator, shapes: jax.Array) -> jax.Array:
    return operator.targets(shapes).reshape(-1, 3)


def _sources(operator: TrainOperator, shapes: jax.Array) -> Sources:
    return operator.sources(shapes, operator.forces(shapes))


def _analyse(operator: TrainOperator, sources: Sources) -> jax.Array:
    return operator.tube._far_modes(sources)


def _modes(operator: TrainOperator, shapes: jax.Array) -> jax.Array:
    return _analyse(operator, _sources(operator, shapes))


def _synthesise(operator: TrainOperator, targets: jax.Array, modes: jax.Array) -> jax.Array:
    points = jnp.concatenate([targets, operator.tube.wall.points().reshape(-1, 3)])
    return operator.tube.transform.synthesise(points, modes)


def _near_wall(operator: TrainOperator, sources: Sources) -> jax.Array:
    # The tube's own way, so that the same work is measured.
    strips, _ = operator.tube.wall.strips()
    points = operator.tube.wall.points().reshape(-1, 3)[strips]
    return operator.tube._near(points, jnp.full(len(strips), -1), sources, None)


def _near_cells(operator: TrainOperator, targets: jax.Array, sources: Sources) -> jax.Array:
    cells = sources.cells
    return operator.tube._near(targets.reshape(cells, -1, 3), jnp.arange(cells), sources, None)


def _wall_velocity(operator: TrainOperator, shapes: jax.Array) -> jax.Array:
    points = operator.tube.wall.points()
    random = np.random.default_rng(1)
    return jnp.asarray(random.normal(size=points.shape))


def _wall_flow(operator: TrainOperator, targets: jax.Array, boundary: jax.Array) -> jax.Array:
    wall = operator.tube.wall
    return wall.velocity(targets, wall.regular_flow(boundary))


def _viscous(ratio: float) -> Work:
    """The evaluation at another viscosity ratio; says how many iterations each ratio takes."""
    train = TRAIN.changed(viscosity_ratio=ratio)
    operator = train_operator(train, cells=train.cells)
    shapes = _disturbed()
    compiled = eqx.filter_jit(lambda operator, shapes: operator.solved_rates(shapes))
    for each in RATIOS:
        other = eqx.tree_at(lambda o: o.viscosity_ratio, operator, jnp.asarray(each))
        count = int(compiled(other, shapes)[1].iterations)
        print(f"viscosity ratio {each:g}: {count} iterations", file=sys.stderr)
    return lambda: compiled(operator, shapes)


def _dense(close: bool) -> Work:
    """An evaluation of close cells, off the axis, with and without the rule for them."""
    train = TRAIN.changed(packing=0.7)
    operator = train_operator(train, cells=train.cells, close=close)
    random = np.random.default_rng(0)
    shapes = resting_shapes(train, train.cells)
    shapes[:, :2, 0] += 0.3 * random.normal(size=(train.cells, 2))
    compiled = eqx.filter_jit(lambda operator, shapes: operator.rates(shapes))
    return lambda: compiled(operator, jnp.asarray(shapes))


def _blocks() -> Work:
    shape = _base().coefficients
    waves = 2.0 * np.pi * WAVES / TRAIN.cells
    return lambda: linear_blocks(TRAIN, shape, waves, AZIMUTHAL_NUMBERS)


def _spectrum() -> Work:
    base = _base()
    waves = 2.0 * np.pi * WAVES / TRAIN.cells
    blocks = linear_blocks(TRAIN, base.coefficients, waves, AZIMUTHAL_NUMBERS)
    pairs = [(m, int(j)) for m in AZIMUTHAL_NUMBERS for j in WAVES]

    def work() -> None:
        for m, j in pairs:
            block_spectrum(blocks[m][j], neutral_space(base, m, j))
        for norm in NORMS:
            for m, gram in norm.grams(base.coefficients, AZIMUTHAL_NUMBERS).items():
                for block in blocks[m]:
                    numerical_abscissa(block, gram)

    return work


def _infinite() -> Work:
    base = _base()
    return lambda: infinite_train(base)


#: Name of a stage -> what makes it ready and returns the work to measure.
STAGES: dict[str, Callable[[], Work]] = {
    "evaluation": lambda: _evaluation(lambda operator, shapes: operator.rates(shapes)),
    "evaluation.forces": lambda: _evaluation(_forces),
    "evaluation.own_surface": lambda: _evaluation(
        lambda operator, *inputs: operator.own_velocity(*inputs), _targets, _shapes, _forces
    ),
    "evaluation.far_analyse": lambda: _evaluation(_analyse, _sources),
    "evaluation.far_synthesise": lambda: _evaluation(_synthesise, _loose_targets, _modes),
    "evaluation.near_wall": lambda: _evaluation(_near_wall, _sources),
    "evaluation.near_cells": lambda: _evaluation(_near_cells, _targets, _sources),
    "evaluation.wall_flow": lambda: _evaluation(_wall_flow, _loose_targets, _wall_velocity),
    "viscous": lambda: _viscous(5.0),
    "dense.ordinary": lambda: _dense(False),
    "dense.close": lambda: _dense(True),
    "base": lambda: _base,
    "blocks": _blocks,
    "spectrum": _spectrum,
    "infinite": _infinite,
}


def peak_mib() -> float:
    """Largest resident memory of this process since the last reset, MiB."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmHWM:"):
            return float(line.split()[1]) / 1024.0
    return float("nan")


def reset_peak() -> None:
    """Let the largest resident memory start again from what is resident now."""
    # Where the kernel refuses, the peak is that of the whole process: an upper bound.
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")


def measure(work: Work, runs: int) -> dict[str, float]:
    """Seconds and memory of `runs` runs after a first one."""
    reset_peak()
    begin = time.perf_counter()
    jax.block_until_ready(work())
    first = time.perf_counter() - begin
    seconds = []
    for _ in range(runs):
        begin = time.perf_counter()
        jax.block_until_ready(work())
        seconds.append(time.perf_counter() - begin)
    median = statistics.median(seconds)
    return {
        "seconds": median,
        "first_seconds": max(first - median, 0.0),
        "peak_mib": peak_mib(),
    }


if __name__ == "__main__":
    name, runs = sys.argv[1:3]
    print(json.dumps(measure(STAGES[name](), int(runs))))
