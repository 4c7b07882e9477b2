"""Whether cells overlap each other or the wall: a simulation that goes there means nothing."""

import numpy as np
from jaxtyping import Float

from celltrain.flow.overlaps import overlaps
from celltrain.harmonics import Shapes
from celltrain.harmonics.grid import sphere_grid
from celltrain.parameters import Train

# Boxes around the grid's points are widened by this (r0), since surfaces pass their grid's points.
MARGIN = 0.05


def overlap(train: Train, shapes: Shapes) -> str | None:
    """What overlaps, in words, or None; shapes have their mean points within the train's length.

    The search proper takes as long as the rates, so it is only begun where the boxes of two cells
    meet, or a cell that of the tube.
    """
    degree = train.degree
    grid = sphere_grid(degree, 2 * degree)
    points = np.einsum("pk,cik->cpi", np.asarray(grid.values), shapes)
    radius = np.hypot(points[..., 0], points[..., 1]).max()
    low, high = points.min(axis=1) - MARGIN, points.max(axis=1) + MARGIN
    if radius + MARGIN < train.radius and not _boxes_meet(low, high, train.length):
        return None
    found = overlaps(shapes, period=train.length, radius=train.radius)
    return str(found[0]) if found else None


def _boxes_meet(
    low: Float[np.ndarray, "cell 3"], high: Float[np.ndarray, "cell 3"], length: float
) -> bool:
    """Whether any two boxes meet, images along the tube included."""
    for image in (0, 1):
        shift = np.array([0.0, 0.0, image * length])
        meet = (low[:, None] < high + shift).all(-1) & (low + shift < high[:, None]).all(-1)
        if image == 0:
            np.fill_diagonal(meet, False)
        if meet.any():
            return True
    return False
