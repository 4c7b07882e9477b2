"""The compiled loop for the nearest points of surfaces to points (see `nearest_search`)."""

import math

import numpy as np

from celltrain.compiled.call_frame import (
    flags,
    integers,
    numbers,
    result,
    sizes,
)
from celltrain.compiled.loops import NEAREST
from celltrain.compiled.nearest_search import (
    FOUND,
    FUNCTIONS,
    arranged_shapes,
    search_factors,
    search_one,
)
from celltrain.compiled.shared_work import frame_of, next_part, task

# Pairs that are one part of the shared work.
_PAIRS = 32


@task(NEAREST.name)
def _nearest(work: int) -> int:
    """Parts: `_PAIRS` pairs each."""
    frame = frame_of(work)
    pairs, _ = sizes(frame, 0)
    first = _PAIRS * next_part(work)
    if first >= pairs:
        return 1
    cells, _, size = sizes(frame, 2)
    points = numbers(frame, 0).reshape((pairs, 3))
    cell_of, valid = integers(frame, 1), flags(frame, 4)
    guesses = numbers(frame, 3).reshape((pairs, 2))
    found = result(frame).reshape((pairs, FOUND))
    degree = round(math.sqrt(size))
    factors = search_factors(degree)
    arranged = arranged_shapes(numbers(frame, 2).reshape((cells, 3, size)), degree)
    functions, jets = np.zeros((FUNCTIONS, degree + 1, degree)), np.zeros((2, 6, 3))
    while first < pairs:
        for pair in range(first, min(first + _PAIRS, pairs)):
            if valid[pair] == 0:
                found[pair, 0] = found[pair, 1] = 0.0
                found[pair, 2] = math.inf
                found[pair, 3] = found[pair, 4] = 1.0
                continue
            shape = arranged[cell_of[pair]]
            search_one(points[pair], shape, guesses[pair], factors, functions, jets, found[pair])
        first = _PAIRS * next_part(work)
    return 1
