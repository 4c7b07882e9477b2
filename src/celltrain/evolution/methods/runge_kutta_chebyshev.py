"""Marching a train by the Runge-Kutta-Chebyshev method, with steps and stages chosen as it goes."""

import math
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from jaxtyping import Float

from celltrain.evolution.checks import check_positive
from celltrain.evolution.ending import StepFailed
from celltrain.evolution.methods.chebyshev import (
    chebyshev_step,
    embedded_error,
    largest_stable_step,
    stage_count,
)
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
from celltrain.evolution.methods.radius import spectral_radius
from celltrain.evolution.state import State
from celltrain.parameters import CaseError
from celltrain.quantities import Quantity

# Steps after which the spectral radius is estimated anew, and the margin put on the estimate,
# which comes from below.
RADIUS_STEPS = 25
RADIUS_MARGIN = 1.2


@dataclass(frozen=True)
class ChebyshevMemory:
    """What the next step is chosen from.

    `last_step` and `last_error` are 0 if there was no step yet, `step` and `radius` if they are not
    known yet.
    """

    step: Annotated[float, Quantity("", "r0/U", "size of the next step")]
    last_step: Annotated[float, Quantity("", "r0/U", "size of the last step")]
    last_error: Annotated[
        float, Quantity("", "1", "estimated error of the last step over what was allowed")
    ]
    radius: Annotated[float, Quantity("", "U/r0", "spectral radius, with its margin")]
    radius_age: Annotated[int, Quantity("", "1", "steps since it was estimated")]
    direction: Annotated[
        Float[np.ndarray, "cell 3 coefficient"],
        Quantity("", "1", "last direction of the power iteration", ("cell", "axis", "coefficient")),
    ]


@dataclass(frozen=True)
class RungeKuttaChebyshev(Integrator[ChebyshevMemory]):
    """Second order, explicit, stable for stiff membranes (Sommeijer, Shampine & Verwer 1998).

    `tolerance` bounds the estimated error of a step, the largest displacement of a point of a
    membrane, relative to the largest distance of the membranes from the steady train, that taken as
    1 r0 at most. So small disturbances are as accurate as large ones. Where the repulsion acts the
    error is no more than a tenth of the thinnest film. Nor do volumes have to be corrected by more
    than a hundredth of the tolerance in r0, or 1e-6 r0 if that is more.
    """

    tolerance: Annotated[float, Quantity("", "1", "bound on the error of a step, relative")] = 1e-3
    largest_step: Annotated[float, Quantity("", "r0/U", "bound on a step")] = 10.0
    most_stages: Annotated[
        int, Quantity("", "1", "bound on a step's evaluations, for which it is shortened")
    ] = 200

    def __post_init__(self) -> None:
        check_positive("tolerance", self.tolerance)
        check_positive("largest_step", self.largest_step)
        if self.most_stages < 2:
            raise CaseError(f"most_stages = {self.most_stages} is not allowed; allowed: >= 2")

    def begin(self, state: State) -> ChebyshevMemory:
        """Nothing is known yet."""
        return ChebyshevMemory(
            step=0.0,
            last_step=0.0,
            last_error=0.0,
            radius=0.0,
            radius_age=0,
            # Any direction that holds all modes will do; a fixed one makes runs repeatable.
            direction=np.random.default_rng(0).normal(size=state.shapes.shape),
        )

    def advance(
        self, dynamics: CellDynamics, state: State, memory: ChebyshevMemory
    ) -> Step[ChebyshevMemory]:
        """One accepted step, after as many rejected ones as it takes."""
        begin = dynamics.continuous(state.shapes, state.laps)
        allowed = allowed_error(dynamics, state, begin, self.tolerance)
        work = Work()
        while True:
            memory, evaluations = self._with_radius(dynamics, state, memory)
            longest = largest_stable_step(self.most_stages, memory.radius)
            step = min(memory.step, self.largest_step, longest)
            stages = stage_count(step, memory.radius)
            moved = chebyshev_step(dynamics.rates, state.shapes, state.rates, step, stages)
            after = dynamics.state(state.time + step, dynamics.continuous(moved, state.laps))
            end = dynamics.continuous(after.shapes, after.laps)
            error = dynamics.displacement(
                embedded_error(begin, state.rates, end, after.rates, step)
            )
            relative, accepted = with_volumes(error / allowed, after, self.tolerance)
            work += Work(evaluations=evaluations + stages)
            if accepted:
                break
            work += Work(rejected=1)
            shorter = shorter_step(step, relative, tolerance=self.tolerance, work=work)
            # A radius that is not of this very state may have been too small.
            age = RADIUS_STEPS if memory.radius_age > 0 else 0
            memory = replace(memory, step=shorter, radius_age=age)
        factor = step_factor(step, relative, memory.last_step, memory.last_error)
        following = replace(
            memory,
            step=min(step * factor, self.largest_step),
            last_step=step,
            last_error=max(relative, SMALLEST_ERROR),
            radius_age=memory.radius_age + 1,
        )
        return Step(after, following, Manner(step, stages, error, memory.radius), work)

    @property
    def retries(self) -> bool:
        """See `Integrator`."""
        return True

    def shortened(self, memory: ChebyshevMemory, size: float) -> ChebyshevMemory | None:
        """See `Integrator`."""
        shorter = OVERLAP_FACTOR * size
        return None if shorter < SMALLEST_RETRY else replace(memory, step=shorter)

    def _with_radius(
        self, dynamics: CellDynamics, state: State, memory: ChebyshevMemory
    ) -> tuple[ChebyshevMemory, int]:
        """The memory with a spectral radius that is recent, and a first step if it has none.

        Also the evaluations that it took.
        """
        if memory.radius > 0.0 and memory.radius_age < RADIUS_STEPS:
            return memory, 0
        found = spectral_radius(dynamics.rates, state.shapes, state.rates, memory.direction)
        if not (math.isfinite(found.radius) and found.radius > 0.0):
            message = "the spectral radius of the rates is NaN"
            raise StepFailed("not_finite", message, evaluations=found.evaluations)
        radius = RADIUS_MARGIN * found.radius
        known = replace(
            memory,
            step=memory.step or 1.0 / radius,
            radius=radius,
            radius_age=0,
            direction=found.direction,
        )
        return known, found.evaluations
