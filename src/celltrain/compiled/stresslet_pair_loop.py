"""The compiled loop over near pairs of a target and a stresslet."""

from typing import Any

from celltrain.compiled.kernels import squared, stresslet_of_dyad, stresslet_scalars
from celltrain.compiled.loops import STRESSLET_PAIRS
from celltrain.compiled.pairs import add_pairs, parts_within
from celltrain.compiled.shared_work import task
from celltrain.parts import FAST, part


@part(fastmath=FAST)
def _stresslet_patch(target: Any, points: Any, dyads: Any, xi: float, within: float) -> Any:
    """Velocity T_near(y - x)_ijk D_jk/2 at one target by a patch of sources, D as [6, source]."""
    u = v = w = 0.0
    for s in range(points.shape[1]):
        d = (target[0] - points[0, s], target[1] - points[1, s], target[2] - points[2, s])
        parts = parts_within(squared(d), xi, within)
        dyad = (dyads[0, s], dyads[1, s], dyads[2, s], dyads[3, s], dyads[4, s], dyads[5, s])
        scalars = stresslet_scalars(parts[0], parts[1], parts[2], xi)
        by = stresslet_of_dyad(scalars, d, dyad)
        u += by[0]
        v += by[1]
        w += by[2]
    return u, v, w


@task(STRESSLET_PAIRS.name)
def _stresslet_pairs(work: int) -> int:
    add_pairs(work, _stresslet_patch)
    return 1
