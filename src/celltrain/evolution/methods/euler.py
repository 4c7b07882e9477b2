"""Marching a train by Euler's explicit method."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from celltrain.evolution.checks import check_positive
from celltrain.evolution.ending import StepFailed
from celltrain.evolution.methods.integrator import CellDynamics, Integrator, Manner, Step, Work
from celltrain.evolution.state import State
from celltrain.quantities import Quantity


@dataclass(frozen=True)
class EulerMemory:
    """How many steps there were."""

    steps: Annotated[int, Quantity("", "1", "steps so far")]


@dataclass(frozen=True)
class ForwardEuler(Integrator[EulerMemory]):
    """Explicit Euler steps of one size, in r0/U: what the paper takes.

    Its 0.0014 r0/U* is 0.014 r0/U (see `celltrain.parameters.units`). Stable for steps up to 2 over
    the spectral radius, which is about 54 U/r0 at degree 12.
    """

    step: Annotated[float, Quantity("h", "r0/U", "size of the steps")] = 0.014

    def __post_init__(self) -> None:
        check_positive("step", self.step)

    def begin(self, state: State) -> EulerMemory:
        """No steps yet."""
        return EulerMemory(0)

    def advance(
        self, dynamics: CellDynamics, state: State, memory: EulerMemory
    ) -> Step[EulerMemory]:
        """One step; no error is estimated, so `error` and `radius` are NaN."""
        moved = state.shapes + self.step * state.rates
        # By multiplication: a sum of many steps would drift.
        time = (memory.steps + 1) * self.step
        after = dynamics.state(time, dynamics.continuous(moved, state.laps))
        if after.measures.gap <= 0.0:
            raise StepFailed("overlap", f"after a step of {self.step:g} r0/U membranes cross")
        if not np.isfinite(after.rates).all():
            raise StepFailed("not_finite", f"a step of {self.step:g} r0/U gave no finite velocity")
        manner = Manner(size=self.step, stages=1, error=float("nan"), radius=float("nan"))
        return Step(after, EulerMemory(memory.steps + 1), manner, Work(evaluations=1))
