"""One place for the settings of JAX, imported by every module that uses it.

* 64-bit floats. They must be switched on before the first array exists.
* The persistent compilation cache, so that the second run of a command does not compile again. Its
  folder is `$JAX_COMPILATION_CACHE_DIR` if that is set, `$XDG_CACHE_HOME/celltrain` or
  `~/.cache/celltrain` otherwise.
* The number of threads of the nonuniform Fourier transforms: one, because at the sizes of a train
  more of them cost more than they bring; `$CELLTRAIN_NUFFT_THREADS` sets another.
* What JAX compiles is reported to the clock (see `clock`).

What must be said before JAX is loaded is in `environment`.
"""

import os
from pathlib import Path

import jax
from jax_finufft.options import Opts

from celltrain.clock import compilation


def _configure() -> None:
    jax.config.update("jax_enable_x64", True)
    if "JAX_COMPILATION_CACHE_DIR" not in os.environ:
        root = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
        jax.config.update("jax_compilation_cache_dir", str(root / "celltrain" / "compiled"))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    jax.monitoring.register_event_duration_secs_listener(compilation.listen)


_configure()

NUFFT_OPTIONS = Opts(nthreads=int(os.environ.get("CELLTRAIN_NUFFT_THREADS", "1")))
