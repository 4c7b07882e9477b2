"""What compiled loops between points and a grid have in common (see `flow.spreading`)."""

import numpy as np

from celltrain.parts import FAST, part

# Grid points along the last axis for each part of the work, at least, and most parts: each of them
# looks at all points.
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


@part(fastmath=FAST)
def _polynomials(terms: np.ndarray, x: np.ndarray, values: np.ndarray) -> None:
    """Values of polynomials [term, polynomial], from the highest term, each at its x."""
    values[:] = terms[0]
    for term in range(1, terms.shape[0]):
        for i in range(x.size):
            values[i] = values[i] * x[i] + terms[term, i]


@part()
def first_covered(place: float, count: int, width: int) -> int:
    """The first grid point, of so many, that a point reaches along an axis."""
    # What is no number becomes some grid point, with weights that are none.
    return int(np.ceil(place - 0.5 * width)) % count


@part()
def cover(
    places: np.ndarray,
    counts: np.ndarray,
    terms: np.ndarray,
    offsets: np.ndarray,
    first: np.ndarray,
    weights: np.ndarray,
) -> None:
    """The first grid point that a point reaches along each axis, and the kernel from there on.

    **Arguments:** `places`: of the point, [axis]; `counts`: of grid points, [axis]; `terms`: of the
    kernel, [term, axis and covered]; `offsets`: room for as many; `weights`: [axis, covered].
    """
    axes, width = weights.shape
    for axis in range(axes):
        first[axis] = first_covered(places[axis], counts[axis], width)
        start = places[axis] - 0.5 * width
        offsets[axis * width : (axis + 1) * width] = np.ceil(start) - start
    _polynomials(terms, offsets, weights.reshape(-1))
    for axis in range(axes):
        # A plane is one layer of a box.
        if counts[axis] == 1:
            weights[axis] = 0.0
            weights[axis, 0] = 1.0
