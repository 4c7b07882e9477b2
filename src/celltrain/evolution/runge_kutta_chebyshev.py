"""Marching a train by the Runge-Kutta-Chebyshev method, with steps and stages chosen as it goes."""

import math
from dataclasses import dataclass, replace

from celltrain.evolution.chebyshev import (
    chebyshev_step,
    embedded_error,
    largest_stable_step,
    stage_count,
)
from celltrain.evolution.dynamics import Dynamics
from celltrain.evolution.integrator import Integrator, StepFailed, check_positive, record
from celltrain.evolution.radius import spectral_radius
from celltrain.evolution.state import Record, State
from celltrain.parameters import CaseError

# Steps after which the spectral radius is estimated anew, and the margin put on the estimate,
# which comes from below.
RADIUS_STEPS = 25
RADIUS_MARGIN = 1.2
# Distance from the steady train (r0) below and above which errors are measured by these.
SMALLEST_SCALE = 1e-6
LARGEST_SCALE = 1.0
# Largest error of a step over the thinnest film within the range of the repulsion.
GAP_SHARE = 0.1
# The next step: this part of what the error allows, between these factors of the last one.
SAFETY = 0.8
LEAST_FACTOR = 0.1
LARGEST_FACTOR = 10.0
# Relative errors below this are taken as this: they say nothing about how errors grow.
SMALLEST_ERROR = 1e-4
SMALLEST_STEP = 1e-6
# A step after which cells overlap is tried again with this part of it, down to a smallest one.
OVERLAP_FACTOR = 0.25
SMALLEST_RETRY = 1e-4


@dataclass(frozen=True)
class RungeKuttaChebyshev(Integrator):
    """Second order, explicit, stable for stiff membranes (Sommeijer, Shampine & Verwer 1998).

    Attributes:
        tolerance: bound on the estimated error of a step, as the largest displacement of a point of
            a membrane relative to the largest distance of the membranes from the steady train, that
            taken as 1 r0 at most. So small disturbances are as accurate as large ones. Where the
            repulsion acts it is no more than a tenth of the thinnest film.
        largest_step: r0/U.
        most_stages: the step is shortened to need no more.
    """

    tolerance: float = 1e-3
    largest_step: float = 10.0
    most_stages: int = 200

    def __post_init__(self) -> None:
        check_positive("tolerance", self.tolerance)
        check_positive("largest_step", self.largest_step)
        if self.most_stages < 2:
            raise CaseError(f"most_stages = {self.most_stages} is not allowed; allowed: >= 2")

    def advance(self, dynamics: Dynamics, state: State) -> tuple[State, Record]:
        """One accepted step, after as many rejected ones as it takes."""
        begin = dynamics.continuous(state.shapes, state.laps)
        distance = dynamics.departure(begin)
        allowed = self.tolerance * min(max(distance, SMALLEST_SCALE), LARGEST_SCALE)
        allowed = min(allowed, GAP_SHARE * state.gap)
        while True:
            state = self._with_radius(dynamics, state)
            longest = largest_stable_step(self.most_stages, state.radius)
            step = min(state.step, self.largest_step, longest)
            stages = stage_count(step, state.radius)
            shapes = chebyshev_step(dynamics.rates, state.shapes, state.rates, step, stages)
            settled = dynamics.settle(dynamics.continuous(shapes, state.laps))
            rates = dynamics.rates(settled.shapes)
            end = dynamics.continuous(settled.shapes, settled.laps)
            error = dynamics.displacement(embedded_error(begin, state.rates, end, rates, step))
            relative = error / allowed
            state = replace(state, evaluations=state.evaluations + stages)
            if relative <= 1.0:
                break
            state = self._shortened(state, step, relative)
        after = replace(
            state,
            time=state.time + step,
            shapes=settled.shapes,
            laps=settled.laps,
            rates=rates,
            step=min(step * _factor(state, step, relative), self.largest_step),
            last_step=step,
            last_error=max(relative, SMALLEST_ERROR),
            gap=settled.gap,
            radius_age=state.radius_age + 1,
            steps=state.steps + 1,
        )
        return after, record(after, settled, stages=stages, error=error, radius=state.radius)

    @property
    def retries(self) -> bool:
        """See `Integrator`."""
        return True

    def shortened(self, state: State, after: State) -> State | None:
        """See `Integrator`."""
        step = OVERLAP_FACTOR * after.last_step
        if step < SMALLEST_RETRY:
            return None
        return replace(state, step=step, rejected=after.rejected + 1, evaluations=after.evaluations)

    def _with_radius(self, dynamics: Dynamics, state: State) -> State:
        """The state with a spectral radius that is recent, and a first step if it has none."""
        if state.radius > 0.0 and state.radius_age < RADIUS_STEPS:
            return state
        found = spectral_radius(dynamics.rates, state.shapes, state.rates, state.direction)
        if not (math.isfinite(found.radius) and found.radius > 0.0):
            raise StepFailed("not_finite", "the spectral radius of the rates is not a number")
        radius = RADIUS_MARGIN * found.radius
        return replace(
            state,
            step=state.step or 1.0 / radius,
            radius=radius,
            radius_age=0,
            direction=found.direction,
            evaluations=state.evaluations + found.evaluations,
        )

    def _shortened(self, state: State, step: float, relative: float) -> State:
        """The state to try again from, after a step whose error was too large or no number."""
        finite = math.isfinite(relative)
        factor = max(SAFETY * relative ** (-1.0 / 3.0), LEAST_FACTOR) if finite else LEAST_FACTOR
        if step * factor < SMALLEST_STEP:
            if not finite:
                raise StepFailed("not_finite", "shapes or velocities are no numbers any more")
            raise StepFailed(
                "step_too_small",
                f"an error of {self.tolerance:g} needs steps below {SMALLEST_STEP:g} r0/U",
            )
        # A radius that is not of this very state may have been too small.
        age = RADIUS_STEPS if state.radius_age > 0 else 0
        return replace(state, step=step * factor, radius_age=age, rejected=state.rejected + 1)


def _factor(state: State, step: float, relative: float) -> float:
    """The next step over this one, from the errors of this one and the one before."""
    error = max(relative, SMALLEST_ERROR)
    factor = SAFETY * error ** (-1.0 / 3.0)
    if state.last_step > 0.0:
        predicted = SAFETY * step / state.last_step * state.last_error ** (1.0 / 3.0)
        factor = min(factor, predicted * error ** (-2.0 / 3.0))
    return min(max(factor, LEAST_FACTOR), LARGEST_FACTOR)
