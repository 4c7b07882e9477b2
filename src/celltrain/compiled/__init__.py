"""Kernels of the three-dimensional operator, and loops that XLA's own code does slowly.

The kernels' arithmetic stands once, in `kernels`. Sums over pairs, sums between points and a grid,
and the search for nearest points are loops compiled by Numba where these serve, their work shared
among threads (`shared_work`), and plain formulas for JAX everywhere else (`dispatch`).
"""

from celltrain.compiled.call_frame import LOOPS_SERVE
from celltrain.compiled.dispatch import compiled_or_plain, loop

__all__ = ["LOOPS_SERVE", "compiled_or_plain", "loop"]
