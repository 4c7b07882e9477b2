"""Kernels of the three-dimensional operator, and loops that XLA's own code does slowly.

The kernels' arithmetic stands once, in `kernels`. Sums over pairs and the search for nearest points
are loops compiled by Numba where these serve, their work shared among threads (`shared_work`), and
plain formulas for JAX everywhere else (`dispatch`).
"""

from celltrain.compiled.call_frame import LOOPS_SERVE
from celltrain.compiled.close_loop import CLOSE_FORCES
from celltrain.compiled.dispatch import compiled_or_plain, loop
from celltrain.compiled.near_loops import FORCE_PAIRS, STRESSLET_PAIRS
from celltrain.compiled.nearest_loop import NEAREST, nearest_on_host
from celltrain.compiled.own_surface_loops import OWN_FORCES

__all__ = [
    "CLOSE_FORCES",
    "FORCE_PAIRS",
    "LOOPS_SERVE",
    "NEAREST",
    "OWN_FORCES",
    "STRESSLET_PAIRS",
    "compiled_or_plain",
    "loop",
    "nearest_on_host",
]
