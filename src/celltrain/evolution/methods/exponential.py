"""Marching a train by an exponential method, for which its linear dynamics costs no steps."""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from jaxtyping import Float

from celltrain.evolution.checks import check_positive
from celltrain.evolution.linear_part import LinearPart, Turns, level_of, step_of
from celltrain.evolution.methods.control import (
    OVERLAP_FACTOR,
    SMALLEST_ERROR,
    SMALLEST_RETRY,
    allowed_error,
    shorter_step,
    step_factor,
)
from celltrain.evolution.methods.integrator import CellDynamics, Integrator, Manner, Step, Work
from celltrain.evolution.state import State
from celltrain.harmonics import Shapes
from celltrain.parameters import CaseError
from celltrain.quantities import Quantity

_DIMENSIONS = ("cell", "axis", "coefficient")
# The first step, r0/U.
FIRST_STEP = 0.1


@dataclass(frozen=True)
class ExponentialMemory:
    """What the next step is chosen from, and what its error is estimated from.

    `last_step` and `last_error` are 0 if there was no step yet, and `back` and `rates` then mean
    nothing.
    """

    step: Annotated[float, Quantity("", "r0/U", "bound on the next step")]
    last_step: Annotated[float, Quantity("", "r0/U", "size of the last step")]
    last_error: Annotated[
        float, Quantity("", "1", "estimated error of the last step over what was allowed")
    ]
    back: Annotated[
        Float[np.ndarray, "cell 3 coefficient"],
        Quantity("", "r0", "shapes before the last step less those after it", _DIMENSIONS),
    ]
    rates: Annotated[
        Float[np.ndarray, "cell 3 coefficient"],
        Quantity("", "U", "rates before the last step", _DIMENSIONS),
    ]


@dataclass(frozen=True)
class ExponentialRungeKutta(Integrator[ExponentialMemory]):
    """Second order, exact for the linear dynamics about the steady train (Cox & Matthews 2002).

    With L the linear part of f (see `celltrain.evolution.linear_part`) a step h from s is

        d = h phi_1(h L) f(s),   s' = s + d + h phi_2(h L) (f(s + d) - f(s) - L d),

    two evaluations of f; its error is estimated by what the last bracket would be if it went on
    from the step before. Steps follow how far the train is from its linear dynamics, not the
    stiffness of its membranes. Its tolerance is that of `RungeKuttaChebyshev`.
    """

    tolerance: Annotated[float, Quantity("", "1", "bound on the error of a step, relative")] = 1e-3
    largest_step: Annotated[float, Quantity("", "r0/U", "bound on a step")] = 10.0

    def __post_init__(self) -> None:
        check_positive("tolerance", self.tolerance)
        check_positive("largest_step", self.largest_step)

    def begin(self, state: State) -> ExponentialMemory:
        """A first step is tried."""
        nothing = np.zeros_like(state.shapes)
        return ExponentialMemory(FIRST_STEP, 0.0, 0.0, nothing, nothing)

    def advance(
        self, dynamics: CellDynamics, state: State, memory: ExponentialMemory
    ) -> Step[ExponentialMemory]:
        """One accepted step, after as many rejected ones as it takes.

        **Raises:** `StepFailed`; `CaseError` for cells without a steady train.
        """
        linear = dynamics.linear_part
        if linear is None:
            raise CaseError("ExponentialRungeKutta marches trains; allowed: RungeKuttaChebyshev")
        begin = dynamics.continuous(state.shapes, state.laps)
        allowed = allowed_error(dynamics, state, begin, self.tolerance)
        turns = linear.turns(state.shapes)
        work = Work()
        while True:
            level = level_of(min(memory.step, self.largest_step))
            step = step_of(level)
            change = step * linear.phi_1(level, turns, state.rates)
            rates = dynamics.rates(state.shapes + change)
            work += Work(evaluations=1)
            rest = rates - state.rates - linear.applied(turns, change)
            correction = step * linear.phi_2(level, turns, rest)
            error = dynamics.displacement(
                correction
                if memory.last_step == 0.0
                else self._error(linear, level, turns, state, memory, rest)
            )
            relative = error / allowed
            if relative <= 1.0:
                moved = dynamics.continuous(state.shapes + change + correction, state.laps)
                after = dynamics.state(state.time + step, moved)
                work += Work(evaluations=1)
                if np.isfinite(after.rates).all():
                    break
                relative = np.nan
            work += Work(rejected=1)
            shorter = shorter_step(step, relative, tolerance=self.tolerance, work=work)
            memory = replace(memory, step=shorter)
        factor = step_factor(step, relative, memory.last_step, memory.last_error)
        following = ExponentialMemory(
            step=min(step * factor, self.largest_step),
            last_step=step,
            last_error=max(relative, SMALLEST_ERROR),
            back=begin - dynamics.continuous(after.shapes, after.laps),
            rates=state.rates,
        )
        manner = Manner(size=step, stages=2, error=error, radius=float("nan"))
        return Step(after, following, manner, work, exponential=True)

    @property
    def needs_train(self) -> bool:
        """See `Integrator`."""
        return True

    def _error(
        self,
        linear: LinearPart,
        level: int,
        turns: Turns,
        state: State,
        memory: ExponentialMemory,
        rest: Shapes,
    ) -> Shapes:
        """What the end of a step is wrong by, from the rest of the rates there.

        For a rest that is smooth in time, its extrapolation from the step before has 3 + 3 r times
        the error of this step, r the ratio of the steps (Milne's device). Twice what that gives is
        taken, because `rest` is known at s + d only, not at the end itself.
        """
        step = step_of(level)
        before = memory.rates - state.rates - linear.applied(turns, memory.back)
        ratio = memory.last_step / step
        return step * linear.phi_2(level, turns, rest + before / ratio) / (1.5 + 1.5 * ratio)

    @property
    def retries(self) -> bool:
        """See `Integrator`."""
        return True

    def shortened(self, memory: ExponentialMemory, size: float) -> ExponentialMemory | None:
        """See `Integrator`."""
        shorter = OVERLAP_FACTOR * size
        return None if shorter < SMALLEST_RETRY else replace(memory, step=shorter)
