"""Marching a train by Euler's explicit method."""

from dataclasses import dataclass, replace

import numpy as np

from celltrain.evolution.dynamics import Dynamics
from celltrain.evolution.integrator import Integrator, StepFailed, check_positive, record
from celltrain.evolution.state import Record, State


@dataclass(frozen=True)
class ForwardEuler(Integrator):
    """Explicit Euler steps of one size, in r0/U: what the paper takes.

    Its 0.0014 r0/U* is 0.014 r0/U (see `celltrain.parameters.units`). Stable for steps up to 2 over
    the spectral radius, which is about 54 U/r0 at degree 12.
    """

    step: float = 0.014

    def __post_init__(self) -> None:
        check_positive("step", self.step)

    def advance(self, dynamics: Dynamics, state: State) -> tuple[State, Record]:
        """One step; no error is estimated, so `error` and `radius` are not numbers."""
        moved = state.shapes + self.step * state.rates
        settled = dynamics.settle(dynamics.continuous(moved, state.laps))
        if settled.gap <= 0.0:
            raise StepFailed("overlap", f"after a step of {self.step:g} r0/U membranes cross")
        rates = dynamics.rates(settled.shapes)
        if not np.isfinite(rates).all():
            raise StepFailed("not_finite", f"a step of {self.step:g} r0/U gave no finite velocity")
        after = replace(
            state,
            # By multiplication: a sum of many steps would drift.
            time=(state.steps + 1) * self.step,
            shapes=settled.shapes,
            laps=settled.laps,
            rates=rates,
            step=self.step,
            last_step=self.step,
            gap=settled.gap,
            steps=state.steps + 1,
            evaluations=state.evaluations + 1,
        )
        return after, record(after, settled, stages=1, error=float("nan"), radius=float("nan"))
