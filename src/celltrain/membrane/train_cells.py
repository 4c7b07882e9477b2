"""The cells of a train: their membrane, as their parameters describe it, and where they are."""

import numpy as np

from celltrain.harmonics import Shape, Shapes, displaced_along, profile_of
from celltrain.membrane.axisymmetric import AxisymmetricMembrane, axisymmetric_membrane
from celltrain.membrane.material import cell_material
from celltrain.membrane.resting import resting_shape
from celltrain.parameters import Train


def meridian_membrane(train: Train) -> AxisymmetricMembrane:
    """The membrane of a train's cells, at the train's degree, for axisymmetric shapes.

    **Raises:** `CaseError` if the train has no degree, or there is no such shape at rest.
    """
    cell, sizes = train.cell, train.sizes
    rest = profile_of(resting_shape(cell, sizes.degree, sizes.grading))
    return axisymmetric_membrane(*cell_material(cell), rest, energy_order=sizes.energy_order)


def place_cells(shape: Shape, train: Train, cells: int) -> Shapes:
    """Copies of one cell, one period apart along the tube."""
    shapes = np.repeat(np.asarray(shape)[None], cells, axis=0)
    return displaced_along(shapes, train.period * np.arange(cells))
