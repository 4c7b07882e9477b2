"""What the compiled loops over the pairs of a target and a source point share.

The same sums of the same `kernels` as the formulas in `flow.near`, but five to seven times as fast
as XLA's code for these: one pass over the pairs, and no arrays over them. They have no derivatives
of their own.
"""

import math
from typing import Any

from celltrain.compiled.call_frame import (
    flags,
    integers,
    numbers,
    result,
    sizes,
)
from celltrain.compiled.kernels import squared
from celltrain.compiled.scaled_erfc import SCALED_ERFC, SCALED_ERFC_MIDDLE
from celltrain.compiled.shared_work import frame_of, next_part
from celltrain.parts import FAST, part

# exp(-x) is the 64th power of exp(-x/64), by its series about the middle of 0 <= x <= 40, beyond
# which it is nothing.
_LARGEST, _MIDDLE = 40.0, 40.0 / 128.0
_SERIES = tuple(math.exp(-_MIDDLE) * (-1.0) ** k / math.factorial(k) for k in range(12))
_ERFC, _ERFC_MIDDLE = tuple(SCALED_ERFC[::-1]), SCALED_ERFC_MIDDLE
_GAUSS = 2.0 / math.sqrt(math.pi)


@part(fastmath=FAST, inline="always")
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


@part(fastmath=FAST, inline="always")
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


@part(fastmath=FAST, inline="always")
def parts_within(square: float, xi: float, within: float) -> tuple[float, float, float]:
    """The parts of the near kernel, the first two 0 where r^2 is not below `within`."""
    screened, gauss, inverse_square = near_parts(square, xi)
    kept = 0.0 if square >= within else 1.0
    return kept * screened, kept * gauss, inverse_square


@part()
def _beyond(target: Any, reach: Any) -> bool:
    """Whether a target is out of a patch's range [middle, squared radius]."""
    away = (target[0] - reach[0], target[1] - reach[1], target[2] - reach[2])
    return squared(away) >= reach[3]


@part(inline="always")
def add_pairs(work: int, add: Any) -> None:
    """The sums over the near pairs of a chunk of targets and an image of a block of sources.

    Arguments as in `flow.near.pair_sums`, the blocks in patches, and the patches' ranges. Parts: a
    chunk with one image of all blocks. `add`: gives the velocity at a target by a patch.
    """
    frame = frame_of(work)
    chunks, size, _ = sizes(frame, 0)
    blocks, patches, _, count = sizes(frame, 1)
    parts = sizes(frame, 2)[2]
    targets = numbers(frame, 0).reshape((chunks, size, 3))
    points = numbers(frame, 1).reshape((blocks, patches, 3, count))
    strengths = numbers(frame, 2).reshape((blocks, patches, parts, count))
    near, cells = flags(frame, 3), integers(frame, 4)
    rows, close = integers(frame, 5), flags(frame, 6)
    ranges = numbers(frame, 7).reshape((blocks, patches, 4))
    xi, period, cutoff = numbers(frame, 8)
    within = cutoff * cutoff
    sums = result(frame)
    images = sums.size // (chunks * size * 3)
    by_part = sums.reshape((images * chunks, size, 3))
    by_cell = rows.size // (images * chunks)
    number = next_part(work)
    while number < images * chunks:
        by_part[number] = 0.0
        image, chunk = divmod(number, chunks)
        shift = (image - images // 2) * period
        for b in range(blocks):
            if near[number * blocks + b] == 0:
                continue
            row = rows[number * by_cell + cells[b]] if by_cell > 0 else -1
            for t in range(size):
                if row >= 0 and close[row * size + t] != 0:
                    continue
                x, y, z = targets[chunk, t]
                at = (x, y, z - shift)
                for p in range(patches):
                    if _beyond(at, ranges[b, p]):
                        continue
                    u, v, w = add(at, points[b, p], strengths[b, p], xi, within)
                    by_part[number, t, 0] += u
                    by_part[number, t, 1] += v
                    by_part[number, t, 2] += w
        number = next_part(work)
