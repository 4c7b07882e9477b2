"""Files that are whole at every moment.

A file is never changed in place: it is written to a temporary file in the same folder, flushed to
the disk (fsync), and moved over the old one by one atomic rename. So whoever opens it, also after a
kill or a crash at any moment, finds the complete file of this writing or of the one before. Where
the path is a symbolic link, what it points to is replaced.
"""

import hashlib
import itertools
import os
import platform
from collections.abc import Callable
from pathlib import Path

_ENDING = ".part"
#: Longest ending that a temporary file takes over, for libraries that go by it.
_LONGEST_SUFFIX = 8
# Two threads may write one file: one that ends the process saves what the other may be saving.
_numbers = itertools.count()


def replace_file(path: Path, write: Callable[[Path], object]) -> None:
    """Make or replace a file by what `write` writes to the path that it is given.

    That path has the ending of the file's own, such as `.png`, if it is a short one.

    **Raises:** `OSError` if it cannot be written; the old file is left as it was.
    """
    path = target(path)
    suffix = path.suffix if len(path.suffix) <= _LONGEST_SUFFIX else ""
    name = f"{beside(path)}.{os.getpid()}.{next(_numbers)}{_ENDING}{suffix}"
    part = path.with_name(name)
    try:
        write(part)
        _flush(part)
        os.replace(part, path)
        _flush(path.parent)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def remove_leftovers(path: Path) -> None:
    """Remove temporary files of this file that killed processes of this machine left behind."""
    path = target(path)
    beginning = f"{beside(path)}."
    for part in path.parent.glob(f"{beginning}*{_ENDING}*"):
        number = part.name.removeprefix(beginning).split(".")[0]
        if number.isdigit() and not _alive(int(number)):
            part.unlink(missing_ok=True)


def target(path: Path) -> Path:
    """The file that a path means: that at the end of symbolic links, also if it is not there."""
    return Path(os.path.realpath(path))


def beside(path: Path) -> str:
    """Beginning of the names of files that go with a file, hidden and of 33 characters.

    A file's own name may be as long as names can be. The machine's name enters, as a folder may be
    shared by several, each with its own processes.
    """
    words = f"{platform.node()}/{path.name}".encode(errors="surrogateescape")
    return f".celltrain.{hashlib.sha256(words).hexdigest()[:22]}"


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
