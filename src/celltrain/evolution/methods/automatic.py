"""Marching a train by whichever method needs fewer evaluations at the time."""

import math
from dataclasses import dataclass, replace
from typing import Annotated

from celltrain.evolution.checks import check_positive
from celltrain.evolution.ending import StepFailed
from celltrain.evolution.methods.exponential import ExponentialAdams, ExponentialMemory
from celltrain.evolution.methods.integrator import CellDynamics, Integrator, Step, Work
from celltrain.evolution.methods.runge_kutta_chebyshev import (
    RADIUS_STEPS,
    ChebyshevMemory,
    RungeKuttaChebyshev,
)
from celltrain.evolution.state import State
from celltrain.quantities import Quantity

# Steps over which evaluations are counted.
COUNTED = 8
# Steps after a change of the method that are not counted: what errors of the other one left in fast
# modes holds stabilised steps back at first.
SETTLING_EXPONENTIAL, SETTLING_STABILISED = 8, 24
# Evaluations by stabilised steps after which exponential ones are tried again.
AGAIN = 1500
# Evaluations per r0/U of stabilised steps before they are counted.
ASSUMED_COST = 5.0
# Part of the tolerance that exponential steps are given. At equal ones they leave more in what fast
# modes carry, which stabilised steps damp: of two cells 2 % of the distance from the axis and 12 %
# of the turning, where those leave 0.02 % and 0.2 %.
EXPONENTIAL_PART = 0.1


@dataclass(frozen=True)
class AutomaticMemory:
    """What both methods remember, and how many evaluations they take.

    `evaluations` and `time` are those of the steps that are being counted.
    """

    exponential: ExponentialMemory
    chebyshev: ChebyshevMemory
    stabilised: Annotated[bool, Quantity("", "1", "whether the next step is a stabilised one")]
    stabilised_cost: Annotated[
        float, Quantity("", "U/r0", "evaluations per time of stabilised steps, as last counted")
    ]
    steps: Annotated[int, Quantity("", "1", "steps since this method was chosen")]
    spent: Annotated[int, Quantity("", "1", "evaluations since this method was chosen")]
    evaluations: Annotated[int, Quantity("", "1", "evaluations in the counted steps")]
    time: Annotated[float, Quantity("", "r0/U", "time that the counted steps cover")]


@dataclass(frozen=True)
class Automatic(Integrator[AutomaticMemory]):
    """`ExponentialAdams` near the steady train, `RungeKuttaChebyshev` where that is cheaper.

    Exponential steps have a tenth of the tolerance, with which they leave about as much as
    stabilised ones. Evaluations are counted as it goes: exponential steps go on until they take
    more than stabilised ones took, or than these mostly take, and are tried again from time to
    time.
    """

    tolerance: Annotated[float, Quantity("", "1", "bound on the error of a step, relative")] = 1e-3
    largest_step: Annotated[float, Quantity("", "r0/U", "bound on a step")] = 10.0

    def __post_init__(self) -> None:
        check_positive("tolerance", self.tolerance)
        check_positive("largest_step", self.largest_step)

    @property
    def _exponential(self) -> ExponentialAdams:
        return ExponentialAdams(EXPONENTIAL_PART * self.tolerance, self.largest_step)

    @property
    def _chebyshev(self) -> RungeKuttaChebyshev:
        return RungeKuttaChebyshev(self.tolerance, self.largest_step)

    def begin(self, state: State) -> AutomaticMemory:
        """With exponential steps."""
        return AutomaticMemory(
            exponential=self._exponential.begin(state),
            chebyshev=self._chebyshev.begin(state),
            stabilised=False,
            stabilised_cost=ASSUMED_COST,
            steps=0,
            spent=0,
            evaluations=0,
            time=0.0,
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
            # Exponential steps in place of stabilised ones that fail are worth any cost.
            cost = math.inf if memory.stabilised else memory.stabilised_cost
            changed = _changed(replace(memory, stabilised_cost=cost))
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
    memory = replace(memory, steps=memory.steps + 1, spent=memory.spent + step.work.evaluations)
    settling = SETTLING_STABILISED if memory.stabilised else SETTLING_EXPONENTIAL
    counted = memory.steps - settling
    if counted > 0:
        evaluations = memory.evaluations + step.work.evaluations
        memory = replace(memory, evaluations=evaluations, time=memory.time + step.manner.size)
    if counted > 0 and counted % COUNTED == 0:
        cost = memory.evaluations / memory.time
        memory = replace(memory, evaluations=0, time=0.0)
        if memory.stabilised:
            memory = replace(memory, stabilised_cost=cost)
        if memory.spent >= AGAIN if memory.stabilised else cost > memory.stabilised_cost:
            memory = _changed(memory)
    return Step(step.state, memory, step.manner, step.work, step.exponential)


def _changed(memory: AutomaticMemory) -> AutomaticMemory:
    """The memory with the other method.

    Neither method knows the last step then, nor the spectral radius of this state.
    """
    return replace(
        memory,
        exponential=replace(memory.exponential, last_step=0.0, last_error=0.0),
        chebyshev=replace(memory.chebyshev, last_step=0.0, last_error=0.0, radius_age=RADIUS_STEPS),
        stabilised=not memory.stabilised,
        steps=0,
        spent=0,
        evaluations=0,
        time=0.0,
    )
