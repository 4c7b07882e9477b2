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
    with_volumes,
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
    """What the next step is chosen from, and the step before, from which rates are extrapolated.

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
class ExponentialAdams(Integrator[ExponentialMemory]):
    """Third order, exact for the linear dynamics about the steady train.

    An exponential Adams method (Hochbruck & Ostermann 2011), here a predictor and a corrector. With
    L the linear part of f (see `celltrain.evolution.linear_part`), f(s + d) = f(s) + L d + g(d),
    and the step before of length h/r = last_step, from s + d_0 to s, a step h predicts

        d = h phi_1(h L) f(s) - h r phi_2(h L) g(d_0),

    on the straight line through the known g, and then takes the parabola through g(d) as well:

        s' = s + h phi_1(h L) f(s) + h phi_2(h L) (g(d) - b) + 2 h phi_3(h L) b,
        b = (g(d) + r g(d_0))/(1 + 1/r),

    two evaluations of f. Its error is taken to be what b changes, which is the error of the method
    of second order without b (Cox & Matthews 2002); that makes the first step, whose error is taken
    to be what g(d) changes. Steps follow how far the train is from its linear dynamics, not the
    stiffness of its membranes. `tolerance` means what it does in `RungeKuttaChebyshev`, also for
    volumes, but fast modes keep larger errors: a tenth of it leaves about as much.
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
            raise CaseError("ExponentialAdams marches trains; allowed: RungeKuttaChebyshev")
        begin = dynamics.continuous(state.shapes, state.laps)
        allowed = allowed_error(dynamics, state, begin, self.tolerance)
        turns = linear.turns(state.shapes)
        work = Work()
        while True:
            level = level_of(min(memory.step, self.largest_step))
            step = step_of(level)
            straight = step * linear.phi_1(level, turns, state.rates)
            expected = _expected(linear, turns, state, memory, step)
            change = straight + step * linear.phi_2(level, turns, expected)
            rates = dynamics.rates(state.shapes + change)
            work += Work(evaluations=1)
            rest = rates - state.rates - linear.applied(turns, change)
            change = straight + step * linear.phi_2(level, turns, rest)
            if memory.last_step == 0.0:
                error = dynamics.displacement(change - straight)
            else:
                bend = (rest - expected) / (1.0 + memory.last_step / step)
                twice = 2.0 * linear.phi_3(level, turns, bend)
                bent = step * (twice - linear.phi_2(level, turns, bend))
                error = dynamics.displacement(bent)
                change = change + bent
            relative = error / allowed
            if relative <= 1.0:
                moved = dynamics.continuous(state.shapes + change, state.laps)
                after = dynamics.state(state.time + step, moved)
                work += Work(evaluations=1)
                finite = bool(np.isfinite(after.rates).all())
                end = relative if finite else np.nan
                relative, accepted = with_volumes(end, after, self.tolerance)
                if accepted:
                    break
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

    @property
    def retries(self) -> bool:
        """See `Integrator`."""
        return True

    def shortened(self, memory: ExponentialMemory, size: float) -> ExponentialMemory | None:
        """See `Integrator`."""
        shorter = OVERLAP_FACTOR * size
        return None if shorter < SMALLEST_RETRY else replace(memory, step=shorter)


def _expected(
    linear: LinearPart, turns: Turns, state: State, memory: ExponentialMemory, step: float
) -> Shapes:
    """What the rates will have beside L d after a step, on the line through the step before."""
    if memory.last_step == 0.0:
        return np.zeros_like(state.rates)
    before = memory.rates - state.rates - linear.applied(turns, memory.back)
    return -step / memory.last_step * before
