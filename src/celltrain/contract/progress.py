"""How a computation tells how far it is."""

from typing import Protocol, runtime_checkable

from celltrain.steady import Iteration


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
