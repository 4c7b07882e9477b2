"""What JAX keeps of compiled programs, where the disk was full or the process was killed.

JAX writes such a file in place and never again: one that was cut short would be read, warned of and
compiled anew by every later command. So it is removed when JAX warns of it, before it is written.
"""

import glob
import os
import re
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TextIO

from celltrain.environment import PROGRAMS

#: JAX's warning; what goes wrong, the program's name or key, and why.
_WARNING = re.compile(
    r"Error (reading|writing) persistent compilation cache entry for '([^']+)':"
    r" (?:\w+: )?(?:\[Errno \d+\] )?(.*)"
)


@contextmanager
def mended_programs() -> Iterator[None]:
    """Remove damaged programs of our own folder, and say once why none can be kept."""
    show = warnings.showwarning
    told = False

    def mend(
        message: Warning | str,
        category: type[Warning],
        filename: str,
        lineno: int,
        file: TextIO | None = None,
        line: str | None = None,
    ) -> None:
        nonlocal told
        found = _WARNING.match(str(message))
        if found is None or not _remove(found[2]):
            show(message, category, filename, lineno, file, line)
        elif found[1] == "writing" and not told:
            told = True
            print(f"celltrain: what was compiled cannot be kept: {found[3]}", file=sys.stderr)

    warnings.showwarning = mend
    try:
        yield
    finally:
        warnings.showwarning = show


def _remove(program: str) -> bool:
    """Remove what is kept of a program; whether it is ours to keep."""
    if PROGRAMS is None or not _kept_here():
        return False
    for path in glob.glob(os.path.join(glob.escape(PROGRAMS), f"{glob.escape(program)}*-cache")):
        with suppress(OSError):
            os.remove(path)
    return True


def _kept_here() -> bool:
    jax = sys.modules.get("jax")
    return jax is not None and jax.config.jax_compilation_cache_dir == PROGRAMS
