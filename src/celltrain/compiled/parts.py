"""Parts of loops: functions that Numba compiles for other compiled functions only.

Python cannot call them: the wrappers for that would take a quarter of the time to compile.
"""

from functools import partial

from numba import njit

#: Decorator of such a function, `@part(...)` with Numba's options.
part = partial(njit, error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)
#: Value of the option `fastmath` for sums, which may be taken in any order; NaN stays NaN.
FAST = {"contract", "reassoc", "nsz", "arcp"}
