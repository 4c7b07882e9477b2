"""Steady trains and their linear dynamics, a stage a process: ``meridian_stages.py NAME RUNS``.

Prints one JSON object (see `measuring.measure`). Nothing here loads JAX.
"""

import math

from measuring import Work, run_stage

from celltrain import Base, Train, steady
from celltrain.stability import (
    NORMS,
    block_spectrum,
    infinite_train,
    linear_blocks,
    neutral_space,
    numerical_abscissa,
)
from celltrain.steady.problem import SteadyProblem

TRAIN = Train(diameter=6, packing=0.2, cells=8, degree=12)
WAVES = range(TRAIN.cells // 2 + 1)
PHASES = [2.0 * math.pi * j / TRAIN.cells for j in WAVES]


def _base(degree: int, viscosity_ratio: float = 1.0) -> Base:
    return steady(TRAIN.changed(degree=degree, viscosity_ratio=viscosity_ratio))


def _steady(degree: int) -> Work:
    return lambda: _base(degree)


def _newton(degree: int) -> Work:
    """One of Newton's iterations: a shape's velocity, its derivatives, and the step from there."""
    base = _base(degree)
    problem = SteadyProblem(base.train)
    rules = problem.rules(base.profile)

    def work() -> None:
        state = problem.state(base.profile, rules)
        state.step(math.inf)
        assert state.residual < 1e-6

    return work


def _blocks(degree: int, viscosity_ratio: float = 1.0) -> Work:
    base = _base(degree, viscosity_ratio)
    return lambda: linear_blocks(base, PHASES, range(degree + 1))


def _spectrum(degree: int) -> Work:
    """All eigenvalues and vectors, and the numerical abscissas in every norm."""
    base = _base(degree)
    numbers = range(degree + 1)
    blocks = linear_blocks(base, PHASES, numbers)

    def work() -> None:
        for m in numbers:
            for j in WAVES:
                block_spectrum(blocks[m][j], neutral_space(base, m, j))
        for norm in NORMS:
            for m, gram in norm.grams(base.coefficients, numbers).items():
                for block in blocks[m]:
                    numerical_abscissa(block, gram)

    return work


def _infinite(degree: int) -> Work:
    base = _base(degree)
    return lambda: infinite_train(base, estimate_error=False)


STAGES = {
    "base": lambda: _steady(12),
    "base.24": lambda: _steady(24),
    "newton": lambda: _newton(12),
    "newton.24": lambda: _newton(24),
    "blocks": lambda: _blocks(12),
    "blocks.24": lambda: _blocks(24),
    "blocks.48": lambda: _blocks(48),
    "blocks.viscous": lambda: _blocks(12, 5.0),
    "spectrum": lambda: _spectrum(12),
    "spectrum.24": lambda: _spectrum(24),
    "infinite": lambda: _infinite(12),
}


if __name__ == "__main__":
    run_stage(STAGES)
