"""What a command leaves behind: its result on standard output first, then files and pictures.

What fails after the result was printed takes nothing of it along: it is said in one line each, and
the command ends with the status `NOT_KEPT`. What writes is imported when it is needed.
"""

import errno
import os
import sys
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console

from celltrain.contract.status import ExitStatus

if TYPE_CHECKING:
    from celltrain.contract import Draw
    from celltrain.quantities import Record


#: Standard error, on which one live display may be at a time.
ERRORS = Console(stderr=True)


def say(words: str) -> None:
    """A line on standard error, as it is."""
    ERRORS.print(words, markup=False, highlight=False, soft_wrap=True)


class Report(Console):
    """Standard output for reports: that it is closed is said by an error, which can be told."""

    def on_broken_pipe(self) -> None:
        """Called by rich while it handles that error; its own way would end the process."""
        raise BrokenPipeError(errno.EPIPE, os.strerror(errno.EPIPE))


class Keeper:
    """Prints and writes what is to be kept, one after another, whatever fails.

    With `listed` the names of the files are the result: they go to standard output.
    """

    def __init__(self, *, quiet: bool = True, listed: bool = False) -> None:
        self._quiet, self._listed = quiet, listed
        self._complete = True

    @property
    def status(self) -> int:
        """Exit status by what was kept: 0 if all was."""
        return ExitStatus.DONE if self._complete else ExitStatus.NOT_KEPT

    def show(self, write: Callable[[], object]) -> None:
        """Print to standard output, which may be full, or closed by who read it."""
        try:
            if sys.stdout is None:
                raise OSError("it is closed")
            write()
            sys.stdout.flush()
        except OSError as error:
            self._lost("standard output could not be written", error)
            _drop_standard_output()

    def file(self, path: Path, write: Callable[[Path], object]) -> None:
        """Write a file by a function that raises `OSError` where it cannot."""
        try:
            write(path)
        except OSError as error:
            self._lost(f"{str(path)!r} could not be written", error)
        else:
            self._made("wrote", path)

    def text(self, path: Path, text: str) -> None:
        """Write a text file at once."""
        from celltrain.results import replace_file

        def write(path: Path) -> None:
            replace_file(path, lambda part: part.write_text(text, encoding="utf-8"))

        self.file(path, write)

    def picture(self, path: Path, draw: Callable[[Path], object]) -> None:
        """Draw a picture, or a film, by a function that writes it."""
        try:
            draw(path)
        except Exception as error:  # whatever a library finds on this machine
            self._drawn(path, error)
        else:
            self._drawn(path, None)

    def saved(self, path: Path, result: "Record") -> None:
        """Save a result."""
        from celltrain.results import save  # files take half a second to load

        self.file(path, lambda path: save(result, path))

    def pictures(self, found: "Callable[[], Mapping[str, Draw]]", folder: Path) -> None:
        """Draw pictures into a folder."""
        from celltrain.contract.files import draw_each

        for path, failure in draw_each(found, folder):
            self._drawn(path, failure)

    def result(self, result: "Record", output: Path | None, plot: Path | None) -> None:
        """Save a result, and draw its pictures into a folder, where these are asked for."""
        from celltrain.contract import presentation

        shown = presentation(result.kind)
        if output is not None:
            for path, each in shown.files(result, output).items():
                self.saved(path, each)
        if plot is not None:
            self.pictures(partial(shown.pictures, result), plot)

    def _drawn(self, path: Path, failure: Exception | None) -> None:
        if failure is None:
            self._made("drew", path)
        else:
            self._lost(f"{str(path)!r} could not be drawn", failure)

    def _made(self, how: str, path: Path) -> None:
        if self._listed:
            self.show(lambda: print(path))
        elif not self._quiet:
            say(f"{how} {path}")

    def _lost(self, what: str, error: Exception) -> None:
        self._complete = False
        say(f"celltrain: {what}: {reason(error)}")


def _drop_standard_output() -> None:
    """Let what is left in its buffer go nowhere: it must not fail again when the process ends."""
    if sys.__stdout__ is None or sys.stdout is not sys.__stdout__:
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.__stdout__.fileno())
    os.close(nowhere)


def reason(error: Exception) -> str:
    """What went wrong, in the words of the system where they are its own."""
    return getattr(error, "strerror", None) or str(error) or type(error).__name__
