"""How compiled loops between points and a grid divide their work: in slabs across the last axis."""

from celltrain.parts import part

# Grid points of a slab along its axis; more of them where there would be too many slabs, each of
# which looks at all points.
DEPTH, MOST = 30, 64


@part()
def slab_depth(count: int) -> int:
    """Grid points of each slab along an axis of so many."""
    return max(DEPTH, -(-count // MOST))
