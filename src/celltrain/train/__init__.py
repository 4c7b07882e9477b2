"""A train of cells: from their shapes to the rates at which they change."""

from celltrain.train.accuracy import rates_error
from celltrain.train.geometry import (
    area_vectors,
    clearance,
    largest_radius,
    meridian,
    size_at_rest,
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
from celltrain.train.parameters import (
    PARAMETERS,
    check_parameters,
    parameter_value,
    parameters_of,
    with_parameter,
)
from celltrain.train.variation import Variation, variation

__all__ = [
    "PARAMETERS",
    "TrainOperator",
    "Variation",
    "area_vectors",
    "check_parameters",
    "clearance",
    "close_distance",
    "largest_radius",
    "meridian",
    "parameter_value",
    "parameters_of",
    "place_cells",
    "rates_error",
    "resting_shapes",
    "size_at_rest",
    "streamwise_gap",
    "train_membrane",
    "train_operator",
    "variation",
    "volume_gradient",
    "with_parameter",
]
