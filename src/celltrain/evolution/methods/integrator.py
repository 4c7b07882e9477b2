"""How a train is marched in time: one small interface."""

import abc
from dataclasses import dataclass
from typing import Annotated, Generic, TypeVar

from celltrain.evolution.dynamics import Dynamics
from celltrain.evolution.state import State
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
        float, Quantity(r"\rho", "U/r0", "spectral radius for which the step is stable")
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
    """One step: where it led, what the method remembers of it, how it was taken, at what cost."""

    state: State
    memory: MemoryT
    manner: Manner
    work: Work


class Integrator(abc.ABC, Generic[MemoryT]):
    """A way to march; an object of its own settings.

    All that changes are the state, which is physics, and the memory, which is the method's own: a
    dataclass whose fields say what they are.
    """

    @abc.abstractmethod
    def begin(self, state: State) -> MemoryT:
        """What the method remembers where a simulation begins."""

    @abc.abstractmethod
    def advance(self, dynamics: Dynamics, state: State, memory: MemoryT) -> Step[MemoryT]:
        """One step from a state.

        **Raises:** `StepFailed`.
        """

    @property
    def retries(self) -> bool:
        """Whether a step after which cells overlap may be tried again, shorter."""
        return False

    def shortened(self, memory: MemoryT, step: Step[MemoryT]) -> MemoryT | None:
        """The memory to try again with, if a step led where none may; None: it is the end.

        **Arguments:** `memory`: the one before the step.
        """
        return None
