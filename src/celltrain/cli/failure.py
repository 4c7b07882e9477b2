"""How a command ends that cannot do what it was asked for."""


class CommandFailed(RuntimeError):
    """The message to show, and the exit status that goes with it."""

    def __init__(self, message: str, status: int) -> None:
        super().__init__(message)
        self.status = status


def reason(error: Exception) -> str:
    """What went wrong, in the words of the system where they are its own."""
    return getattr(error, "strerror", None) or str(error) or type(error).__name__
