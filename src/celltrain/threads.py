"""How many threads the numerical libraries take; to be imported before NumPy is.

One for the small factorisations of LAPACK (`$OPENBLAS_NUM_THREADS` sets another number): its
threads wait for each other for longer than these take, above all on a busy machine.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

#: Environment of a process that computes in one thread, beside others that do the same.
ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "CELLTRAIN_NUFFT_THREADS": "1",
    # XLA's own pool.
    "NPROC": "1",
}
