"""How a train is marched in time: one small interface."""

import abc
from dataclasses import asdict
from typing import Any

import numpy as np
from jaxtyping import Float

from celltrain.evolution.dynamics import Dynamics, Settled
from celltrain.evolution.ending import EndingKind
from celltrain.evolution.state import Record, State
from celltrain.parameters import CaseError


class StepFailed(RuntimeError):
    """No step can be taken from a state; why as a word (see `Ending`) and as a sentence."""

    def __init__(self, kind: EndingKind, message: str) -> None:
        super().__init__(message)
        self.kind = kind


class Integrator(abc.ABC):
    """A way to march; an object of its own settings, so that a state holds all that changes."""

    def begin(
        self, dynamics: Dynamics, shapes: Float[np.ndarray, "cell 3 coefficient"]
    ) -> tuple[State, Record]:
        """The state at time 0 with the given (continuous) shapes, and its record.

        **Raises:** `StepFailed` if the rates there are not finite.
        """
        settled = dynamics.settle(shapes)
        rates = dynamics.rates(settled.shapes)
        if not np.isfinite(rates).all():
            raise StepFailed("not_finite", "the first shapes have no finite velocity")
        state = State(
            time=0.0,
            shapes=settled.shapes,
            laps=settled.laps,
            rates=rates,
            step=0.0,
            last_step=0.0,
            last_error=0.0,
            radius=0.0,
            radius_age=0,
            # Any direction that holds all modes will do; a fixed one makes runs repeatable.
            direction=np.random.default_rng(0).normal(size=rates.shape),
            steps=0,
            rejected=0,
            evaluations=1,
            gap=settled.gap,
            wall_gap=dynamics.wall_gap,
        )
        return state, record(state, settled, stages=0, error=0.0, radius=float("nan"))

    @abc.abstractmethod
    def advance(self, dynamics: Dynamics, state: State) -> tuple[State, Record]:
        """The state after one step, and the record of the step.

        **Raises:** `StepFailed`.
        """

    @property
    def retries(self) -> bool:
        """Whether a step after which cells overlap may be tried again, shorter."""
        return False

    def shortened(self, state: State, after: State) -> State | None:
        """A state to try again from, if a step led to one that may not be; None: it is the end."""
        return None

    def settings(self) -> dict[str, Any]:
        """The fields by name, from which the integrator can be made again."""
        return asdict(self)  # type: ignore[call-overload, no-any-return]


def record(state: State, settled: Settled, *, stages: int, error: float, radius: float) -> Record:
    """The record of the step that led to a state."""
    return Record(
        time=state.time,
        eps=settled.eps,
        eps_x=settled.eps_x,
        energy=settled.energy,
        area=settled.area,
        volume_correction=settled.volume_correction,
        gap=settled.gap,
        film_energy=settled.film_energy,
        film_force=settled.film_force,
        size=state.last_step,
        stages=stages,
        error=error,
        radius=radius,
        rejected=state.rejected,
        evaluations=state.evaluations,
    )


def check_positive(name: str, value: float) -> None:
    """See to it that a setting is a positive number.

    **Raises:** `CaseError`.
    """
    if not (np.isfinite(value) and value > 0.0):
        raise CaseError(f"{name} = {value!r} is not allowed; allowed: a number > 0")
