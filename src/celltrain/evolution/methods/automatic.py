"""Marching a train by whichever method needs fewer evaluations at the time."""

import math
from dataclasses import dataclass, replace
from typing import Annotated

from celltrain.evolution.checks import check_positive
from celltrain.evolution.ending import StepFailed
from celltrain.evolution.methods.exponential import ExponentialMemory, ExponentialRungeKutta
from celltrain.evolution.methods.integrator import CellDynamics, Integrator, Step, Work
from celltrain.evolution.methods.runge_kutta_chebyshev import (
    RADIUS_STEPS,
    ChebyshevMemory,
    RungeKuttaChebyshev,
)
from celltrain.evolution.state import State
from celltrain.quantities import Quantity

# Steps over which evaluations are counted. The other method is tried again after this many times
# the evaluations that its last counted steps took.
COUNTED = 8
AGAIN = 20
# Evaluations per r0/U, and in a step, of stabilised steps before that is known.
ASSUMED_COST, ASSUMED_STAGES = 4.0, 16


@dataclass(frozen=True)
class AutomaticMemory:
    """What both methods remember, and how many evaluations each of them takes."""

    exponential: ExponentialMemory
    chebyshev: ChebyshevMemory
    stabilised: Annotated[bool, Quantity("", "1", "whether the next step is a stabilised one")]
    spent: Annotated[
        int,
        Quantity(
            "", "1", "evaluations by this method since it was chosen, without those being counted"
        ),
    ]
    steps: Annotated[int, Quantity("", "1", "steps that are being counted")]
    evaluations: Annotated[int, Quantity("", "1", "evaluations in them")]
    time: Annotated[float, Quantity("", "r0/U", "time that they cover")]
    other_cost: Annotated[
        float, Quantity("", "U/r0", "evaluations per time by the other method when last counted")
    ]
    other_evaluations: Annotated[
        int, Quantity("", "1", "evaluations in the steps of the other method when last counted")
    ]


@dataclass(frozen=True)
class Automatic(Integrator[AutomaticMemory]):
    """`ExponentialRungeKutta` near the steady train, `RungeKuttaChebyshev` where that is cheaper.

    Both are of second order with the same bound on the error of a step. Which one takes fewer
    evaluations is counted as it goes; the other one is tried where it may be cheaper, and from time
    to time.
    """

    tolerance: Annotated[float, Quantity("", "1", "bound on the error of a step, relative")] = 1e-3
    largest_step: Annotated[float, Quantity("", "r0/U", "bound on a step")] = 10.0

    def __post_init__(self) -> None:
        check_positive("tolerance", self.tolerance)
        check_positive("largest_step", self.largest_step)

    @property
    def _exponential(self) -> ExponentialRungeKutta:
        return ExponentialRungeKutta(self.tolerance, self.largest_step)

    @property
    def _chebyshev(self) -> RungeKuttaChebyshev:
        return RungeKuttaChebyshev(self.tolerance, self.largest_step)

    def begin(self, state: State) -> AutomaticMemory:
        """With exponential steps."""
        return AutomaticMemory(
            exponential=self._exponential.begin(state),
            chebyshev=self._chebyshev.begin(state),
            stabilised=False,
            spent=0,
            steps=0,
            evaluations=0,
            time=0.0,
            other_cost=ASSUMED_COST,
            other_evaluations=COUNTED * ASSUMED_STAGES,
        )

    def advance(
        self, dynamics: CellDynamics, state: State, memory: AutomaticMemory
    ) -> Step[AutomaticMemory]:
        """One accepted step, after as many rejected ones as it takes.

        **Raises:** `StepFailed` if no method can take one.
        """
        try:
            return self._by_its_method(dynamics, state, memory)
        except StepFailed as failure:
            changed = _changed(memory, math.inf, COUNTED * ASSUMED_STAGES)
            step = self._by_its_method(dynamics, state, changed)
            return replace(step, work=step.work + Work(failure.rejected, failure.evaluations))

    def _by_its_method(
        self, dynamics: CellDynamics, state: State, memory: AutomaticMemory
    ) -> Step[AutomaticMemory]:
        if memory.stabilised:
            stabilised = self._chebyshev.advance(dynamics, state, memory.chebyshev)
            return _counted(stabilised, replace(memory, chebyshev=stabilised.memory))
        exponential = self._exponential.advance(dynamics, state, memory.exponential)
        return _counted(exponential, replace(memory, exponential=exponential.memory))

    @property
    def needs_train(self) -> bool:
        """See `Integrator`."""
        return True

    @property
    def retries(self) -> bool:
        """See `Integrator`."""
        return True

    def shortened(self, memory: AutomaticMemory, size: float) -> AutomaticMemory | None:
        """See `Integrator`; both, as either may take the next step where the other one fails."""
        exponential = self._exponential.shortened(memory.exponential, size)
        chebyshev = self._chebyshev.shortened(memory.chebyshev, size)
        if exponential is None or chebyshev is None:
            return None
        return replace(memory, exponential=exponential, chebyshev=chebyshev)


def _counted(
    step: Step[ExponentialMemory] | Step[ChebyshevMemory], memory: AutomaticMemory
) -> Step[AutomaticMemory]:
    """The step with what is remembered after it: which method takes the next one, above all."""
    steps = memory.steps + 1
    evaluations = memory.evaluations + step.work.evaluations
    time = memory.time + step.manner.size
    if steps < COUNTED:
        following = replace(memory, steps=steps, evaluations=evaluations, time=time)
    else:
        cost, spent = evaluations / time, memory.spent + evaluations
        if cost > memory.other_cost or spent >= AGAIN * memory.other_evaluations:
            following = _changed(memory, cost, evaluations)
        else:
            following = replace(memory, spent=spent, steps=0, evaluations=0, time=0.0)
    return Step(step.state, following, step.manner, step.work, step.exponential)


def _changed(memory: AutomaticMemory, cost: float, evaluations: int) -> AutomaticMemory:
    """The memory with the other method, from what this one costs.

    Neither knows the last step, nor the spectral radius of this state.
    """
    return replace(
        memory,
        exponential=replace(memory.exponential, last_step=0.0, last_error=0.0),
        chebyshev=replace(memory.chebyshev, last_step=0.0, last_error=0.0, radius_age=RADIUS_STEPS),
        stabilised=not memory.stabilised,
        spent=0,
        steps=0,
        evaluations=0,
        time=0.0,
        other_cost=cost,
        other_evaluations=evaluations,
    )
