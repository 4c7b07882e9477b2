"""How a train is marched in time: one small interface."""

import abc
from dataclasses import dataclass
from typing import Annotated, Generic, Protocol, TypeVar, runtime_checkable

import numpy as np
from jaxtyping import Int

from celltrain.evolution.linear_part import LinearPart
from celltrain.evolution.state import State
from celltrain.harmonics import Shapes
from celltrain.quantities import Quantity

MemoryT = TypeVar("MemoryT")


@dataclass(frozen=True)
class Manner:
    """How a step was taken."""

    size: Annotated[float, Quantity("h", "r0/U", "size of the step, 0 for the beginning")]
    stages: Annotated[
        int, Quantity("s", "1", "evaluations of the velocity that the step itself took")
    ]
    error: Annotated[
        float,
        Quantity("", "r0", "estimated error of the step, the largest displacement of a membrane"),
    ]
    radius: Annotated[
        float,
        Quantity(
            r"\rho", "U/r0", "spectral radius for which the step is stable, NaN if it needs none"
        ),
    ]


@dataclass(frozen=True)
class Work:
    """What was done: steps that were rejected, and evaluations of the velocity."""

    rejected: Annotated[int, Quantity("", "1", "steps rejected since the beginning")] = 0
    evaluations: Annotated[
        int, Quantity("", "1", "evaluations of the velocity since the beginning")
    ] = 0

    def __add__(self, other: "Work") -> "Work":
        return Work(self.rejected + other.rejected, self.evaluations + other.evaluations)


@dataclass(frozen=True)
class Step(Generic[MemoryT]):
    """One step: where it led, what the method remembers of it, how it was taken, at what cost.

    `exponential`: whether between its ends shapes follow the linear dynamics, however fast.
    """

    state: State
    memory: MemoryT
    manner: Manner
    work: Work
    exponential: bool = False


@runtime_checkable
class CellDynamics(Protocol):
    """What a method needs of the dynamics of cells (`evolution.dynamics.Dynamics`, in JAX)."""

    @property
    def linear_part(self) -> LinearPart | None:
        """The linear dynamics about the steady train, None where there is none."""

    def rates(self, shapes: Shapes) -> Shapes:
        """ds/dt of shapes within one period, in U."""

    def continuous(self, shapes: Shapes, laps: Int[np.ndarray, " cell"]) -> Shapes:
        """Shapes where the cells have really gone, not put back by periods."""

    def state(self, time: float, shapes: Shapes) -> State:
        """The state with the given (continuous) shapes at a time."""

    def displacement(self, change: Shapes) -> float:
        """Largest displacement of a membrane's point by a change of the shapes, in r0."""

    def departure(self, shapes: Shapes) -> float:
        """Largest distance of a membrane's point from the steady train, of continuous shapes."""


class Integrator(abc.ABC, Generic[MemoryT]):
    """A way to march; an object of its own settings.

    All that changes are the state, which is physics, and the memory, which is the method's own: a
    dataclass whose fields say what they are.
    """

    @abc.abstractmethod
    def begin(self, state: State) -> MemoryT:
        """What the method remembers where a simulation begins."""

    @abc.abstractmethod
    def advance(self, dynamics: CellDynamics, state: State, memory: MemoryT) -> Step[MemoryT]:
        """One step from a state.

        **Raises:** `StepFailed`.
        """

    @property
    def needs_train(self) -> bool:
        """Whether it marches cells of a train only."""
        return False

    @property
    def retries(self) -> bool:
        """Whether a step after which cells overlap may be tried again, shorter."""
        return False

    def shortened(self, memory: MemoryT, size: float) -> MemoryT | None:
        """The memory to try again with, if a step led where none may; None: it is the end.

        **Arguments:** `memory`: the one before the step; `size`: of that step (r0/U).
        """
        return None
