"""What is to be kept when the process is asked to end while it computes.

Who computes for long says how to keep what there is (`kept_by`), for the case that the computation
itself cannot do it: machine code that runs for minutes hears no signal. Who listens to signals (the
command line) then has it kept by another thread, and ends the process.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

_keepers: list[Callable[[], str]] = []
_taken = False


@contextmanager
def kept_by(keep: Callable[[], str]) -> Iterator[None]:
    """Within this, `keep` keeps what there is, in any thread, and returns where it is in words."""
    _keepers.append(keep)
    try:
        yield
    finally:
        _keepers.remove(keep)


def keep_all() -> str:
    """Keep what there is, the innermost computation's first; in words, empty if there is nothing.

    A failure is one of the words.
    """
    words = []
    for keep in reversed(_keepers):
        try:
            words.append(keep())
        except Exception as error:  # whatever it is, the process ends
            words.append(f"not saved: {error}")
    return "; ".join(each for each in words if each)


def take() -> None:
    """Say that an interruption has been heard and is being dealt with: no other one is needed."""
    global _taken
    _taken = True


def taken() -> bool:
    """Whether it is dealt with."""
    return _taken


def forget() -> None:
    """Begin anew, as when another command is run in this process."""
    global _taken
    _taken = False
