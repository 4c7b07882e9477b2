"""Settings that libraries read when they are loaded; so this is the package's first import.

* One thread for the small factorisations of LAPACK (`$OPENBLAS_NUM_THREADS` sets another number):
  its threads wait for each other for longer than these take, above all on a busy machine.
* How XLA compiles (see `xla_flags`), and the level of its own messages. JAX is not loaded here, but
  modules that use it may load it before they come to `runtime`.
* Folders for what Numba and Matplotlib keep, where theirs cannot be used: they would end with an
  error, or a warning.
"""

import atexit
import os
import sys
import time

from celltrain.xla_flags import xla_flags


class UnsuitableSetting(RuntimeError):
    """A setting of the process or of a library with which nothing can be computed."""


#: Whether JAX, which reads the level of messages once and sets it to 1, was loaded before.
JAX_CAME_FIRST = "jaxlib" in sys.modules and os.environ.get("TF_CPP_MIN_LOG_LEVEL") != "3"

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ["XLA_FLAGS"] = xla_flags()
# XLA reports every cached program as compiled for "another machine", because it lists its own
# tuning preferences among the processor's features. Set the variable to 0 to see all messages.
os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")


def _cache() -> str | None:
    """The folder for what is compiled, made if need be; None if the user has none to write to.

    It is `$XDG_CACHE_HOME/celltrain` or `~/.cache/celltrain`.
    """
    root = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    folder = os.path.join(root, "celltrain")
    try:
        if not os.path.isabs(folder):  # no home
            return None
        os.makedirs(folder, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None


def _without_home() -> None:
    """Let libraries keep what they keep for the length of this process."""
    import shutil
    import tempfile

    folder = tempfile.mkdtemp(prefix="celltrain-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    os.environ.setdefault("MPLCONFIGDIR", folder)
    if not os.access(os.path.dirname(__file__), os.W_OK):
        os.environ.setdefault("NUMBA_CACHE_DIR", folder)


#: Folder for what is compiled, None if there is none that can be written to.
CACHE = _cache()
if CACHE is None:
    _without_home()

#: Where JAX keeps compiled programs, unless the user has given it a folder.
PROGRAMS = None if CACHE is None else os.path.join(CACHE, "compiled")
#: Whether whole programs are kept there, so that they need not be traced either (see `programs`).
KEEPS_PROGRAMS = False


def processors() -> int:
    """How many processors this process may use, as XLA counts them."""
    asked = os.environ.get("NPROC", "")
    if asked.isdigit() and int(asked) > 0:
        return int(asked)
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


#: When this process came to the package, in seconds since the epoch.
STARTED = time.time()

#: Environment of a process that computes in one thread, beside others that do the same.
ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    # XLA's own pool.
    "NPROC": "1",
}
