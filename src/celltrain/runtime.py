"""One place for the settings of JAX that the whole package relies on.

* 64-bit floats. They must be switched on before the first array exists, so every subpackage that
  uses JAX imports this module first.
* The persistent compilation cache, so that the second run of a command does not compile again. Its
  folder is `$JAX_COMPILATION_CACHE_DIR` if that is set, `$XDG_CACHE_HOME/celltrain` or
  `~/.cache/celltrain` otherwise.
* How XLA compiles (see `xla_flags`).
* The level of XLA's own messages.
* The number of threads of the nonuniform Fourier transforms: one, because at the sizes of a train
  more of them cost more than they bring; `$CELLTRAIN_NUFFT_THREADS` sets another.
* One thread for the small factorisations of LAPACK (`$OPENBLAS_NUM_THREADS` sets another number):
  its threads wait for each other for longer than these take, above all on a busy machine.
* A clock that tells compilation from running (`timed`).
"""

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from celltrain.xla_flags import xla_flags

# XLA reports every cached program as compiled for "another machine", because it lists its own
# tuning preferences among the processor's features. Set the variable to 0 to see all messages.
os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ["XLA_FLAGS"] = xla_flags()

import jax
from jax_finufft.options import Opts


def _configure() -> None:
    jax.config.update("jax_enable_x64", True)
    if "JAX_COMPILATION_CACHE_DIR" not in os.environ:
        root = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
        jax.config.update("jax_compilation_cache_dir", str(root / "celltrain" / "compiled"))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)


_configure()

#: Environment of a process that computes in one thread, beside others that do the same.
ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "CELLTRAIN_NUFFT_THREADS": "1",
    # XLA's own pool.
    "NPROC": "1",
}

NUFFT_OPTIONS = Opts(nthreads=int(os.environ.get("CELLTRAIN_NUFFT_THREADS", "1")))


class _CompileClock:
    """Seconds spent in tracing, lowering and compiling, overlapping reports counted once."""

    def __init__(self) -> None:
        self._spans: list[tuple[float, float]] = []
        self._settled = 0.0

    def listen(self, event: str, duration_secs: float, **_: str | int) -> None:
        if not event.startswith("/jax/core/compile/"):
            return
        end = time.perf_counter()
        start = end - duration_secs
        # Reports come when a span ends, so a longer one replaces those that it encloses.
        while self._spans and self._spans[-1][0] >= start:
            self._spans.pop()
        self._spans.append((start, end))
        if len(self._spans) > 1000:
            oldest = self._spans.pop(0)
            self._settled += oldest[1] - oldest[0]

    def seconds(self) -> float:
        return self._settled + sum(end - start for start, end in self._spans)


_clock = _CompileClock()
jax.monitoring.register_event_duration_secs_listener(_clock.listen)


@contextmanager
def timed(seconds: dict[str, float], stage: str) -> Iterator[None]:
    """Add the time of a block to `seconds[stage]`, its compilation to `seconds["compile"]`.

    What a block computes must be fetched or waited for inside it.
    """
    begin, compiled = time.perf_counter(), _clock.seconds()
    try:
        yield
    finally:
        compiling = _clock.seconds() - compiled
        seconds["compile"] = seconds.get("compile", 0.0) + compiling
        elapsed = time.perf_counter() - begin - compiling
        seconds[stage] = seconds.get(stage, 0.0) + max(elapsed, 0.0)
