"""The exit statuses of commands, which `docs/reliability.md` explains to users."""

from enum import IntEnum


class ExitStatus(IntEnum):
    """How a command ended."""

    DONE = 0
    #: Input that is not allowed; nothing was written.
    BAD_INPUT = 2
    #: No steady train, a curve or a simulation that could not go on, or failed cases of a study.
    NOT_CONVERGED = 3
    #: Something was lost: what could not be written, too little memory, workers that went away.
    NOT_KEPT = 4
    INTERRUPTED = 130


def curve_status(ending: str) -> ExitStatus:
    """Of a curve by the kind of its ending: what was found of it is kept in all cases."""
    known = {"lost": ExitStatus.NOT_CONVERGED, "interrupted": ExitStatus.INTERRUPTED}
    return known.get(ending, ExitStatus.DONE)


class ComputationFailed(RuntimeError):
    """Why there is no result, and the exit status that goes with it."""

    def __init__(self, message: str, status: ExitStatus = ExitStatus.NOT_CONVERGED) -> None:
        super().__init__(message)
        self.status = status
