"""The command line: ``celltrain stability``, ``celltrain base``, ``celltrain case``."""

import gc
import os
import sys
from collections.abc import Sequence
from contextlib import suppress

from celltrain import environment
from celltrain.cli.interrupts import Interrupts
from celltrain.cli.kept_programs import mended_programs
from celltrain.cli.streams import prepare_streams

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line (``sys.argv`` unless given) and return the exit status; see `app`.

    Signals are listened to from here on. An interruption is told in one line, and ends the process
    at once if the arguments are its own: what libraries do at its end may take long.
    """
    if arguments is None:
        # What a command loads and traces stays: to look through it again and again for what does
        # not takes a tenth of the time.
        gc.set_threshold(50_000, 20, 50)
        environment.KEEPS_PROGRAMS = os.environ.get("CELLTRAIN_KEEP_PROGRAMS", "1") != "0"
        prepare_streams()
        # No window is opened, and Matplotlib ends with an error for a name that it does not know.
        os.environ["MPLBACKEND"] = "agg"
        # Workers' semaphores are left to a process of Python's own, which would speak of them.
        sys.warnoptions.append("ignore::UserWarning:multiprocessing.resource_tracker")
    with Interrupts() as interrupts:
        try:
            from celltrain.cli.app import run  # takes long

            with mended_programs():
                return run(arguments)
        except BaseException as error:
            interrupted = isinstance(error, KeyboardInterrupt)
            if not interrupted and interrupts.asked is None:
                raise
            status = interrupts.end(str(error) if interrupted else "")
        if arguments is None:
            with suppress(OSError, ValueError, AttributeError):
                sys.stdout.flush()
            os._exit(status)
    return status
