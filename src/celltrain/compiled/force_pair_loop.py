"""The compiled loop over near pairs of a target and a force."""

from typing import Any

from celltrain.compiled.kernels import squared, stokeslet, stokeslet_scalars
from celltrain.compiled.loops import FORCE_PAIRS
from celltrain.compiled.pairs import add_pairs, near_parts
from celltrain.compiled.shared_work import task
from celltrain.parts import FAST, part


@part(fastmath=FAST)
def _force_block(x: float, y: float, z: float, points: Any, forces: Any, xi: float) -> Any:
    """Velocity at one target by a block of sources [3, source]."""
    u = v = w = 0.0
    for s in range(points.shape[1]):
        d = (x - points[0, s], y - points[1, s], z - points[2, s])
        parts = near_parts(squared(d), xi)
        force = (forces[0, s], forces[1, s], forces[2, s])
        by = stokeslet(stokeslet_scalars(parts[0], parts[1], parts[2]), d, force)
        u += by[0]
        v += by[1]
        w += by[2]
    return u, v, w


@task(FORCE_PAIRS.name)
def _force_pairs(work: int) -> int:
    add_pairs(work, _force_block)
    return 1
