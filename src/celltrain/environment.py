"""Settings that libraries read when they are loaded; so this is the package's first import.

* One thread for the small factorisations of LAPACK (`$OPENBLAS_NUM_THREADS` sets another number):
  its threads wait for each other for longer than these take, above all on a busy machine.
* How XLA compiles (see `xla_flags`), and the level of its own messages. JAX is not loaded here, but
  modules that use it may load it before they come to `runtime`.
"""

import os

from celltrain.xla_flags import xla_flags

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ["XLA_FLAGS"] = xla_flags()
# XLA reports every cached program as compiled for "another machine", because it lists its own
# tuning preferences among the processor's features. Set the variable to 0 to see all messages.
os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")

#: Environment of a process that computes in one thread, beside others that do the same.
ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "CELLTRAIN_NUFFT_THREADS": "1",
    # XLA's own pool.
    "NPROC": "1",
}
