"""Parts of compiled loops: functions that Numba compiles for other compiled functions only.

Python cannot call them: the wrappers for that would take a quarter of the time to compile. Each
becomes part of what calls it. Otherwise it would be one more function, of which a process takes
the first that it comes to, be it another one's, compiled with its sums in another order: results
would depend in their last bits on what else was compiled, and on what was kept.
"""

from functools import partial

from numba import njit

#: Decorator of such a function, `@part(...)` with Numba's options.
part = partial(
    njit,
    error_model="numpy",
    forceinline=True,
    no_cpython_wrapper=True,
    no_cfunc_wrapper=True,
)
#: Value of the option `fastmath` for sums, which may be taken in any order; NaN stays NaN.
FAST = {"contract", "reassoc", "nsz", "arcp"}
