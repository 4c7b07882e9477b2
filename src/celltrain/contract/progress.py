"""How a computation tells how far it is."""

from typing import Protocol, runtime_checkable

from celltrain.steady import Iteration


@runtime_checkable
class SimulationStatus(Protocol):
    """How far a simulation is."""

    @property
    def begin(self) -> float:
        """Time at which it began, or was gone on with, r0/U."""

    @property
    def time(self) -> float:
        """Time that is reached, r0/U."""

    @property
    def until(self) -> float:
        """Last time, r0/U."""

    @property
    def eps(self) -> float:
        """Size of the disturbance (Eq. 8), r0."""

    @property
    def seconds(self) -> float:
        """Wall time since the beginning, s."""


@runtime_checkable
class Progress(Protocol):
    """What computations call; the command line's `Reporter` shows it."""

    def log(self, message: str) -> None:
        """Take a line."""

    def iteration(self, iteration: Iteration) -> None:
        """Take an iteration of the steady train."""

    def share(self, done: int, total: int) -> None:
        """Take how much of the linear dynamics is done."""

    def part(self, title: str, done: int, total: int) -> None:
        """Take how much of something is done."""

    def step(self, status: SimulationStatus) -> None:
        """Take how far a simulation is."""


class Silent:
    """Shows nothing."""

    def log(self, message: str) -> None:
        """Take a line."""

    def iteration(self, iteration: Iteration) -> None:
        """Take an iteration of the steady train."""

    def share(self, done: int, total: int) -> None:
        """Take how much of the linear dynamics is done."""

    def part(self, title: str, done: int, total: int) -> None:
        """Take how much of something is done."""

    def step(self, status: SimulationStatus) -> None:
        """Take how far a simulation is."""
