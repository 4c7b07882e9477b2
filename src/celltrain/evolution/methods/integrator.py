"""How a train is marched in time: one small interface."""

import abc
from dataclasses import asdict, dataclass
from typing import Any, ClassVar, Generic, TypeVar

from celltrain.evolution.dynamics import Dynamics
from celltrain.evolution.state import State

MemoryT = TypeVar("MemoryT")


@dataclass(frozen=True)
class Remembered:
    """What files say of one number of a method's memory, beside which it stands."""

    unit: str
    meaning: str
    dims: tuple[str, ...] = ()


@dataclass(frozen=True)
class Manner:
    """How a step was taken.

    Attributes:
        size: of the step, r0/U; 0 for the beginning.
        stages: evaluations of the velocity that the step itself took.
        error: estimated error of the step, the largest displacement of a membrane, r0.
        radius: spectral radius assumed, U/r0.
    """

    size: float
    stages: int
    error: float
    radius: float


@dataclass(frozen=True)
class Work:
    """What was done: steps that were rejected, and evaluations of the velocity."""

    rejected: int = 0
    evaluations: int = 0

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
    dataclass, of the class `remembers`, whose fields are `Remembered`.
    """

    remembers: ClassVar[type]

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

    def settings(self) -> dict[str, Any]:
        """The fields by name, from which the integrator can be made again."""
        return asdict(self)  # type: ignore[call-overload, no-any-return]
