"""Standard output and standard error, whatever they lead to."""

import io
import os
import sys
from typing import Any, TextIO, cast


class _Forgiving(io.FileIO):
    """Standard error: where nobody can be told that nobody can be told."""

    def write(self, data: Any, /) -> int:
        """Write what can be written."""
        try:
            return super().write(data)
        except OSError:
            return memoryview(data).nbytes


def prepare_streams() -> None:
    """Let no message end a computation, because of its letters or its place."""
    # Where one of them is closed, the next file that is opened would take its number.
    while (number := os.open(os.devnull, os.O_RDWR)) <= 2:
        pass
    os.close(number)
    # Elsewhere, as in a notebook, it is another object.
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")
    if sys.stderr is None:  # closed
        sys.stderr = open(os.devnull, "w")  # noqa: SIM115
        return
    sys.stderr = cast(
        TextIO,
        io.TextIOWrapper(
            io.BufferedWriter(_Forgiving(2, "w", closefd=False)),
            encoding=sys.stderr.encoding,
            errors="backslashreplace",
            line_buffering=True,
        ),
    )
