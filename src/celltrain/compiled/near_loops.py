"""Compiled loops over the pairs of a target and a source point: the near kernels.

The same sums of the same `kernels` as the formulas in `flow.near`, but five to seven times as fast
as XLA's code for these: one pass over the pairs, and no arrays over them. They have no derivatives
of their own.
"""

import math
from typing import Any

from numba import njit

from celltrain.compiled.call_frame import (
    FLAGS,
    FLOATS,
    INTEGERS,
    flags,
    handler,
    integers,
    numbers,
    result,
    sizes,
)
from celltrain.compiled.kernels import (
    squared,
    stokeslet,
    stokeslet_scalars,
    stresslet_of_dyad,
    stresslet_scalars,
)
from celltrain.compiled.scaled_erfc import SCALED_ERFC, SCALED_ERFC_MIDDLE
from celltrain.compiled.shared_work import computed, next_part, shared, task, task_address

# Names under which XLA finds the loops.
FORCE_PAIRS, STRESSLET_PAIRS = (f"celltrain_{name}" for name in ("force_pairs", "stresslet_pairs"))

# Sums may be taken in any order; NaN stays NaN.
FAST = {"contract", "reassoc", "nsz", "arcp"}
# exp(-x) is the 64th power of exp(-x/64), by its series about the middle of 0 <= x <= 40, beyond
# which it is nothing.
_LARGEST, _MIDDLE = 40.0, 40.0 / 128.0
_SERIES = tuple(math.exp(-_MIDDLE) * (-1.0) ** k / math.factorial(k) for k in range(12))
_ERFC, _ERFC_MIDDLE = tuple(SCALED_ERFC[::-1]), SCALED_ERFC_MIDDLE
_GAUSS = 2.0 / math.sqrt(math.pi)
# Types of the loops' arguments.
_PAIR_ARGUMENTS = (FLOATS, FLOATS, FLOATS, FLAGS, INTEGERS, INTEGERS, FLAGS, FLOATS)


@njit(fastmath=FAST, inline="always", error_model="numpy")
def _exponential(x: float) -> float:
    """exp(-x) for x >= 0, to 1e-13."""
    z = (x if x < _LARGEST else _LARGEST) * (1.0 / 64.0) - _MIDDLE
    c, z2 = _SERIES, z * z
    z4 = z2 * z2
    low = (c[0] + c[1] * z) + (c[2] + c[3] * z) * z2
    middle = (c[4] + c[5] * z) + (c[6] + c[7] * z) * z2
    high = (c[8] + c[9] * z) + (c[10] + c[11] * z) * z2
    power = low + (middle + high * z4) * z4
    power *= power
    power *= power
    power *= power
    power *= power
    power *= power
    return power * power


@njit(fastmath=FAST, inline="always", error_model="numpy")
def near_parts(square: float, xi: float) -> tuple[float, float, float]:
    """erfc(xi r)/r, 2 xi/sqrt(pi) exp(-xi^2 r^2) and 1/r^2, from r^2."""
    root = math.sqrt(square)
    inverse, scaled = 1.0 / root, xi * root
    x = 1.0 - (2.0 * _ERFC_MIDDLE) / (scaled + _ERFC_MIDDLE)
    c, x2 = _ERFC, x * x
    x4 = x2 * x2
    x8 = x4 * x4
    lowest = (c[0] + c[1] * x) + (c[2] + c[3] * x) * x2
    low = (c[4] + c[5] * x) + (c[6] + c[7] * x) * x2
    high = (c[8] + c[9] * x) + (c[10] + c[11] * x) * x2
    highest = (c[12] + c[13] * x) + (c[14] + c[15] * x) * x2
    rest = (c[16] + c[17] * x) + c[18] * x2
    polynomial = lowest + low * x4 + (high + highest * x4 + rest * x8) * x8
    gauss = _exponential(scaled * scaled)
    return polynomial * gauss * inverse, _GAUSS * xi * gauss, inverse * inverse


@njit(fastmath=FAST, error_model="numpy")
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


@njit(fastmath=FAST, error_model="numpy")
def _stresslet_block(x: float, y: float, z: float, points: Any, dyads: Any, xi: float) -> Any:
    """Velocity T_near(y - x)_ijk D_jk/2 at one target by a block of sources, D as [6, source]."""
    u = v = w = 0.0
    for s in range(points.shape[1]):
        d = (x - points[0, s], y - points[1, s], z - points[2, s])
        parts = near_parts(squared(d), xi)
        dyad = (dyads[0, s], dyads[1, s], dyads[2, s], dyads[3, s], dyads[4, s], dyads[5, s])
        scalars = stresslet_scalars(parts[0], parts[1], parts[2], xi)
        by = stresslet_of_dyad(scalars, d, dyad)
        u += by[0]
        v += by[1]
        w += by[2]
    return u, v, w


def _pair_loop(block: Any) -> Any:
    """The loop over the near pairs of a chunk of targets and an image of a block of sources.

    Arguments as in `flow.near.pair_sums`. Parts: a chunk with one image of all blocks.
    """

    @njit(error_model="numpy")
    def loop(frame: int, work: int) -> None:
        chunks, size, _ = sizes(frame, 0)
        blocks, _, count = sizes(frame, 1)
        parts = sizes(frame, 2)[1]
        targets = numbers(frame, 0).reshape((chunks, size, 3))
        points = numbers(frame, 1).reshape((blocks, 3, count))
        strengths = numbers(frame, 2).reshape((blocks, parts, count))
        near, cells = flags(frame, 3), integers(frame, 4)
        rows, close = integers(frame, 5), flags(frame, 6)
        xi, period = numbers(frame, 7)
        sums = result(frame)
        images = sums.size // (chunks * size * 3)
        by_part = sums.reshape((images * chunks, size, 3))
        by_cell = rows.size // (images * chunks)
        part = next_part(work)
        while part < images * chunks:
            by_part[part] = 0.0
            image, chunk = divmod(part, chunks)
            shift = (image - images // 2) * period
            for b in range(blocks):
                if near[part * blocks + b] == 0:
                    continue
                row = rows[part * by_cell + cells[b]] if by_cell > 0 else -1
                for t in range(size):
                    if row >= 0 and close[row * size + t] != 0:
                        continue
                    x, y, z = targets[chunk, t]
                    u, v, w = block(x, y, z - shift, points[b], strengths[b], xi)
                    by_part[part, t, 0] += u
                    by_part[part, t, 1] += v
                    by_part[part, t, 2] += w
            part = next_part(work)

    return loop


_force_pairs, _stresslet_pairs = _pair_loop(_force_block), _pair_loop(_stresslet_block)


@task(FORCE_PAIRS)
def _force_pairs_task(work: int) -> int:
    return computed(_force_pairs, work)


@handler(FORCE_PAIRS)
def _force_pairs_handler(frame: int) -> int:
    return shared(frame, _PAIR_ARGUMENTS, task_address(FORCE_PAIRS))


@task(STRESSLET_PAIRS)
def _stresslet_pairs_task(work: int) -> int:
    return computed(_stresslet_pairs, work)


@handler(STRESSLET_PAIRS)
def _stresslet_pairs_handler(frame: int) -> int:
    return shared(frame, _PAIR_ARGUMENTS, task_address(STRESSLET_PAIRS))
