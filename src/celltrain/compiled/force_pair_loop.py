"""The compiled loop over near pairs of a target and a force."""

from typing import Any

from celltrain.compiled.kernels import squared, stokeslet, stokeslet_scalars
from celltrain.compiled.loops import FORCE_PAIRS
from celltrain.compiled.pairs import add_pairs, parts_within
from celltrain.compiled.shared_work import task
from celltrain.parts import FAST, part


@part(fastmath=FAST)
def _force_patch(target: Any, points: Any, forces: Any, xi: float, within: float) -> Any:
    """Velocity at one target by a patch of sources [3, source]."""
    u = v = w = 0.0
    for s in range(points.shape[1]):
        d = (target[0] - points[0, s], target[1] - points[1, s], target[2] - points[2, s])
        parts = parts_within(squared(d), xi, within)
        force = (forces[0, s], forces[1, s], forces[2, s])
        by = stokeslet(stokeslet_scalars(parts[0], parts[1], parts[2]), d, force)
        u += by[0]
        v += by[1]
        w += by[2]
    return u, v, w


@task(FORCE_PAIRS.name)
def _force_pairs(work: int) -> int:
    add_pairs(work, _force_patch)
    return 1
