"""One writer for each file or folder, on one machine or on several that share it.

Who writes holds a lock file beside it, which says who that is. It is locked by the system too
(flock), so that on one machine a lock ends with its process, however that ends; one that another
machine has left cannot be told from one in use.
"""

import errno
import fcntl
import json
import os
import platform
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from celltrain.parameters import CaseError
from celltrain.results.replace import target

_ENDING = ".lock"
# How often each is held by this process: what it calls may lock the same again.
_held: dict[Path, int] = {}
# What file systems say that know no such locks.
_UNKNOWN = (errno.ENOLCK, errno.ENOTSUP, errno.ENOSYS)


@contextmanager
def only_writer(path: Path, name: str = "output") -> Iterator[None]:
    """Within this, no other process has this for the same file or folder.

    `name` is that of the option in messages.

    **Raises:** `CaseError` if another process has it; `OSError` if the lock cannot be made.
    """
    path = target(path)
    if path in _held:
        _held[path] += 1
        try:
            yield
        finally:
            _held[path] -= 1
        return
    lock = path / f".celltrain{_ENDING}" if path.is_dir() else _beside(path)
    handle = _locked(lock, path, name)
    _held[path] = 1
    try:
        yield
    finally:
        del _held[path]
        lock.unlink(missing_ok=True)
        os.close(handle)


def _beside(path: Path) -> Path:
    # Of one name on all machines, unlike those of temporary files.
    name = os.fsencode(path.name)[: 255 - len(f".{_ENDING}")].decode(errors="ignore")
    return path.with_name(f".{name}{_ENDING}")


def _locked(lock: Path, path: Path, name: str) -> int:
    """The lock file, opened and written."""
    while True:
        handle = os.open(lock, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        try:
            here = _take(handle)
            owner = _owner(handle)
            foreign = owner.get("host") not in (None, platform.node())
            if not here or foreign:
                raise _in_use(owner, lock, path, name, foreign=foreign)
            if not _is_at(handle, lock):  # its owner has just removed it
                os.close(handle)
                continue
            words = {"host": platform.node(), "process": os.getpid()}
            with suppress(OSError):  # on a disk that is full the system's lock is enough
                os.truncate(handle, 0)
                os.pwrite(handle, json.dumps(words).encode(), 0)
        except BaseException:
            os.close(handle)
            raise
        return handle


def _take(handle: int) -> bool:
    """Take the system's lock of a file; whether nobody else of this machine has it."""
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError as error:
        if error.errno not in _UNKNOWN:
            raise
        process = _owner(handle).get("process")
        return not isinstance(process, int) or not os.path.exists(f"/proc/{process}")
    return True


def _owner(handle: int) -> dict[str, object]:
    """Who has written a lock file; nothing known if it is empty or something else."""
    try:
        found = json.loads(os.pread(handle, 1000, 0))
    except ValueError:
        return {}
    return found if isinstance(found, dict) else {}


def _is_at(handle: int, lock: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(handle), os.stat(lock))
    except FileNotFoundError:
        return False


def _in_use(
    owner: dict[str, object], lock: Path, path: Path, name: str, *, foreign: bool
) -> CaseError:
    who = f"process {owner.get('process', '(unknown)')} on {owner.get('host', platform.node())}"
    allowed = "another one, or this one when that process has ended"
    if foreign:
        allowed += f"; if it has ended already, remove {str(lock)!r}"
    return CaseError(
        f"{name} = {str(path)!r} is not allowed: {who} is writing it; allowed: {allowed}"
    )
