"""Where results go: checked before anything is computed, so that no result is lost."""

import stat
import tempfile
from pathlib import Path

from celltrain.parameters import CaseError
from celltrain.results.replace import target

#: Where the last state of a failed computation goes when no output file was named.
DEFAULT_LAST = Path("celltrain-last.nc")


def check_output(path: Path, name: str = "output") -> None:
    """Refuse a path that no result can be saved as; an existing file is left as it is.

    ``name`` is that of the option in messages.

    Raises:
        CaseError: if the path is no ordinary file or its folder is not there or not writable.
    """
    try:
        if not stat.S_ISREG(path.stat().st_mode):
            raise CaseError(
                f"{name} = {str(path)!r} is not allowed: it exists and is no regular file"
            )
    except (FileNotFoundError, NotADirectoryError):
        pass
    except OSError as error:  # such as a name that is too long
        raise CaseError(f"{name} = {str(path)!r} cannot be written: {error.strerror}") from None
    folder = target(path).parent
    if not folder.is_dir():
        raise CaseError(f"{name} = {str(path)!r} cannot be written: {str(folder)!r} is no folder")
    try:  # the permission bits alone do not tell (read-only file systems, access lists)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise CaseError(
            f"{name} = {str(path)!r} cannot be written: {error.strerror}; allowed: a file in a"
            " folder that is writable"
        ) from None


def check_folder(path: Path, name: str = "plot") -> None:
    """Make a folder for pictures or other files, and see to it that it can be written to.

    ``name`` is that of the option in messages.

    Raises:
        CaseError: if it cannot be created or not be written to.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            pass
    except OSError as error:
        raise CaseError(
            f"{name} = {str(path)!r} cannot be used: {error.strerror}; allowed: a folder that is"
            " writable or can be created"
        ) from None


def last_state_path(output: Path | None) -> Path:
    """The file for the last state of a computation that failed; never the output file itself."""
    if output is None:
        return DEFAULT_LAST
    return output.with_name(f"{output.stem}.last.nc")
