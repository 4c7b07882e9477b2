"""SIGINT (Ctrl-C) and SIGTERM: a command ends within two seconds, once; a second one at once.

A signal raises `KeyboardInterrupt` in the main thread. That alone is not enough: machine code may
run for minutes before Python looks for signals, and an exception that is raised in a callback of
the garbage collector, as JAX has them, is dropped. So a thread watches: it raises the exception
again where it was dropped, and where nobody has taken it in time it has kept what there is (see
`celltrain.interruption`) and ends the process.

Nothing here imports anything that takes long, so that it comes before all that does.
"""

import os
import select
import signal
import sys
import threading
import time
from contextlib import suppress
from types import FrameType, TracebackType
from typing import Any, NoReturn, Self

from celltrain import interruption

SIGNALS = (signal.SIGINT, signal.SIGTERM)
#: Seconds after which the process is ended from outside its main thread.
PATIENCE = 1.3
#: Seconds between attempts to reach the main thread.
INTERVAL = 0.1
# By which the watching thread wakes the main one: ignored by default, and nobody else's.
_AGAIN = signal.SIGURG


class Interrupts:
    """Listens while a command runs; outside the main thread it does nothing."""

    def __init__(self) -> None:
        #: The signal that asked for the end, if one did.
        self.asked: int | None = None
        self._raised = False
        self._end = threading.Lock()
        self._before: dict[int, Any] = {}

    def __enter__(self) -> Self:
        interruption.forget()
        if threading.current_thread() is not threading.main_thread():
            return self
        self._main = threading.get_ident()
        self._heard, self._tell = os.pipe()
        os.set_blocking(self._tell, False)
        self._wakeup = signal.set_wakeup_fd(self._tell, warn_on_full_buffer=False)
        self._unraisable = sys.unraisablehook
        sys.unraisablehook = self._dropped
        self._watcher = threading.Thread(target=self._watch, name="signals", daemon=True)
        self._watcher.start()
        for number in (*SIGNALS, _AGAIN):
            # A command in the background of a script, or under nohup, ignores SIGINT.
            if signal.getsignal(number) != signal.SIG_IGN:
                self._before[number] = signal.signal(number, self._handle)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if threading.current_thread() is not threading.main_thread():
            return
        for number, handler in self._before.items():
            signal.signal(number, handler)
        signal.set_wakeup_fd(self._wakeup)
        sys.unraisablehook = self._unraisable
        os.write(self._tell, b"\0")
        self._watcher.join()
        os.close(self._heard)
        os.close(self._tell)

    @property
    def status(self) -> int:
        """Exit status by the signal: 130 or 143."""
        return 128 + (self.asked or signal.SIGINT)

    def end(self, kept: str) -> int:
        """Say that the command was interrupted, and what is kept; returns the exit status."""
        interruption.take()
        # Never released: who comes second must not say it again.
        if not self._end.acquire(blocking=False):
            threading.Event().wait()  # the other thread ends the process
        with suppress(OSError, ValueError):
            print(_line(kept), file=sys.stderr, flush=True)
        return self.status

    def _handle(self, number: int, frame: FrameType | None) -> None:
        if number != _AGAIN and self.asked is None:
            self.asked = number
        # Once, until it is dropped: a second one would hit whoever takes the first.
        if self.asked is not None and not self._raised and not interruption.taken():
            self._raised = True
            raise KeyboardInterrupt

    def _dropped(self, unraisable: Any, /) -> None:
        """Called by Python in place of an exception that nobody can catch."""
        if self.asked is not None and issubclass(unraisable.exc_type, KeyboardInterrupt):
            self._raised = False
        else:
            self._unraisable(unraisable)

    def _watch(self) -> None:
        deadline: float | None = None
        signals = 0
        while True:
            wait = None if deadline is None else INTERVAL
            ready, _, _ = select.select([self._heard], [], [], wait)
            for number in os.read(self._heard, 64) if ready else b"":
                if number == 0:
                    return
                if number not in self._before or number == _AGAIN:
                    continue
                signals += 1
                if signals > 1:
                    _show_cursor()
                    os._exit(128 + number)
                self.asked = number
                deadline = time.monotonic() + PATIENCE
            if deadline is None or interruption.taken():
                continue
            if not self._raised:
                signal.pthread_kill(self._main, _AGAIN)
            if time.monotonic() > deadline:
                deadline = float("inf")
                # Keeping may take long; a second signal must be heard meanwhile.
                threading.Thread(target=self._end_here, daemon=True).start()

    def _end_here(self) -> NoReturn:
        if not self._end.acquire(blocking=False):
            threading.Event().wait()  # the main thread has come to its end at last
        kept = interruption.keep_all()
        _show_cursor()
        with suppress(OSError):  # without what might be in use by the main thread
            os.write(2, f"{_line(kept)}\n".encode(errors="backslashreplace"))
        os._exit(self.status)


def _line(kept: str) -> str:
    return f"celltrain: interrupted; {kept or 'nothing was saved'}"


def _show_cursor() -> None:
    # A live display hides it, and leaves its line.
    with suppress(OSError):
        if os.isatty(2):
            os.write(2, b"\r\x1b[K\x1b[?25h")
