"""One place for the settings of JAX, imported first by every module that uses it.

* 64-bit floats. They must be switched on before the first array exists.
* The persistent compilation cache, so that the second run of a command does not compile again. Its
  folder is `$JAX_COMPILATION_CACHE_DIR` if that is set, `$XDG_CACHE_HOME/celltrain` or
  `~/.cache/celltrain` otherwise.
* How XLA compiles (see `xla_flags`).
* The level of XLA's own messages.
* The number of threads of the nonuniform Fourier transforms: one, because at the sizes of a train
  more of them cost more than they bring; `$CELLTRAIN_NUFFT_THREADS` sets another.
* What JAX compiles is reported to the clock (see `clock`).
"""

import os
from pathlib import Path

from celltrain.clock import compilation
from celltrain.xla_flags import xla_flags

# XLA reports every cached program as compiled for "another machine", because it lists its own
# tuning preferences among the processor's features. Set the variable to 0 to see all messages.
os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")
os.environ["XLA_FLAGS"] = xla_flags()

import jax
from jax_finufft.options import Opts


def _configure() -> None:
    jax.config.update("jax_enable_x64", True)
    if "JAX_COMPILATION_CACHE_DIR" not in os.environ:
        root = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
        jax.config.update("jax_compilation_cache_dir", str(root / "celltrain" / "compiled"))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    jax.monitoring.register_event_duration_secs_listener(compilation.listen)


_configure()

NUFFT_OPTIONS = Opts(nthreads=int(os.environ.get("CELLTRAIN_NUFFT_THREADS", "1")))
