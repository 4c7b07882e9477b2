"""Files that are whole at every moment.

A file is never changed in place: it is written to a temporary file in the same folder, flushed to
the disk (fsync), and moved over the old one by one atomic rename. So whoever opens it, also after a
kill or a crash at any moment, finds the complete file of this writing or of the one before.
"""

import os
import platform
from collections.abc import Callable
from pathlib import Path

_ENDING = ".part"


def replace_file(path: Path, write: Callable[[Path], object]) -> None:
    """Make or replace a file by what `write` writes to the path that it is given.

    **Raises:** `OSError` if it cannot be written; the old file is left as it was.
    """
    part = path.with_name(f"{_beginning(path)}{os.getpid()}{_ENDING}")
    try:
        write(part)
        _flush(part)
        os.replace(part, path)
        _flush(path.absolute().parent)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def remove_leftovers(path: Path) -> None:
    """Remove temporary files of this file that killed processes of this machine left behind."""
    beginning = _beginning(path)
    for part in path.absolute().parent.glob(f"{beginning}*{_ENDING}"):
        number = part.name.removeprefix(beginning).removesuffix(_ENDING)
        if number.isdigit() and not _alive(int(number)):
            part.unlink(missing_ok=True)


def _beginning(path: Path) -> str:
    # With the machine's name, as a folder may be shared by several, each with its own processes.
    return f".{path.name}.{platform.node()}."


def _alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return process != os.getpid()


def _flush(path: Path) -> None:
    """Wait until a file, or a folder's list of names, is on the disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
