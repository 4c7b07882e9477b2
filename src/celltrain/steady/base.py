"""The steady train: what a base flow is, and what is known about how it was reached."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float

from celltrain.harmonics import Profile, profile_of
from celltrain.parameters import Train


@dataclass(frozen=True)
class Iteration:
    """One step towards a steady train.

    `residual` is that of the shape before the step, in U; `step` the pseudo-time step in r0/U,
    infinite for Newton's method.
    """

    method: Literal["march", "newton"]
    residual: float
    step: float
    cell_velocity: float


#: Called after every iteration.
IterationProgress = Callable[[Iteration], None]


@dataclass(frozen=True)
class Base:
    """A steady train of equal axisymmetric cells, in r0, U and mu.

    `coefficients` are those of one cell whose mean point is at z = 0; the others are copies, one
    `train.period` apart. `residual` is the largest |v - U_c e_z| on the target grid, v being the
    discrete velocity whose coefficients are the rates of change of the shape; `truncation_error` is
    the same for the velocity before it is cut at the shape's degree: an estimate of what the degree
    leaves out. `velocity_error` estimates what everything else leaves out, relative to the velocity
    (see `rates_error`).
    """

    train: Train
    coefficients: Float[np.ndarray, "3 coefficient"]
    cell_velocity: float
    gap: float
    largest_radius: float
    effective_viscosity: float
    residual: float
    truncation_error: float
    velocity_error: float
    history: tuple[Iteration, ...]
    origin: str
    seconds: dict[str, float]

    @property
    def profile(self) -> Profile:
        """The cells' meridian (see `harmonics.profile`)."""
        return profile_of(self.coefficients)


class NotConverged(RuntimeError):
    """No steady train was found; `last` is the last state and `history` the way to it."""

    def __init__(self, message: str, last: Base) -> None:
        super().__init__(message)
        self.last = last

    @property
    def history(self) -> tuple[Iteration, ...]:
        """The way to the last state."""
        return self.last.history
