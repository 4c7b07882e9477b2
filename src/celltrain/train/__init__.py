"""Trains of cells of any shape: from the shapes to the rates at which they change."""

from celltrain.extras import check_installed

check_installed("simulations")

# ruff: noqa: E402
from celltrain.train.accuracy import rates_error
from celltrain.train.coupling import Coupling, train_coupling
from celltrain.train.fluid_velocity import fluid_velocity
from celltrain.train.operator import (
    CellsOperator,
    cells_membrane,
    cells_operator,
    close_distance,
    resting_shapes,
    train_membrane,
    train_operator,
)

__all__ = [
    "CellsOperator",
    "Coupling",
    "cells_membrane",
    "cells_operator",
    "close_distance",
    "fluid_velocity",
    "rates_error",
    "resting_shapes",
    "train_coupling",
    "train_membrane",
    "train_operator",
]
