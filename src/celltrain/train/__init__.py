"""A train of cells: from their shapes to the rates at which they change."""

from celltrain.train.accuracy import rates_error
from celltrain.train.axisymmetry import axisymmetric_basis, azimuthal_basis, azimuthal_families
from celltrain.train.geometry import (
    area_vectors,
    clearance,
    largest_radius,
    meridian,
    streamwise_gap,
    volume_gradient,
)
from celltrain.train.operator import (
    TrainOperator,
    close_distance,
    place_cells,
    resting_shapes,
    train_membrane,
    train_operator,
)

__all__ = [
    "TrainOperator",
    "area_vectors",
    "axisymmetric_basis",
    "azimuthal_basis",
    "azimuthal_families",
    "clearance",
    "close_distance",
    "largest_radius",
    "meridian",
    "place_cells",
    "rates_error",
    "resting_shapes",
    "streamwise_gap",
    "train_membrane",
    "train_operator",
    "volume_gradient",
]
