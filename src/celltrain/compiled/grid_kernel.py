"""What compiled loops between points and a grid have in common (see `flow.spreading`)."""

import math

import numpy as np

from celltrain.parts import FAST, part

# Most grid points of a slab along the last axis, and most slabs, for which a slab may be deeper:
# for each of them all points are looked at.
DEPTH, MOST_PARTS = 30, 64


@part()
def slab_depth(count: int) -> int:
    """Grid points of each slab, of slabs of about the same depth along an axis of so many."""
    slabs = min(MOST_PARTS, -(-count // DEPTH))
    return -(-count // slabs)


@part(fastmath=FAST)
def add(into: np.ndarray, given: np.ndarray, amount: float) -> None:
    """Add so much of a row to another."""
    for i in range(into.size):
        into[i] += amount * given[i]


@part()
def first_covered(place: float, count: int, width: int) -> int:
    """The first grid point, of so many, that a point reaches along an axis."""
    # NaN gives some grid point; the weights there are NaN.
    return math.ceil(place - 0.5 * width) % count


@part(fastmath=FAST)
def cover(places: np.ndarray, terms: np.ndarray, offsets: np.ndarray, weights: np.ndarray) -> None:
    """The kernel at the grid points that a point reaches along each axis, [axis, covered].

    **Arguments:** `places`: of the point, [axis]; `terms`: [term, axis, covered], from the highest;
    `offsets`: room for as many; `weights`: what is found.
    """
    # Element by element: Numba takes a second to compile the assignment of a row.
    axes, width = weights.shape
    for axis in range(axes):
        start = places[axis] - 0.5 * width
        for i in range(width):
            offsets[axis, i] = math.ceil(start) - start
            weights[axis, i] = 0.0
    for term in range(terms.shape[0]):
        for axis in range(axes):
            for i in range(width):
                weights[axis, i] = weights[axis, i] * offsets[axis, i] + terms[term, axis, i]
