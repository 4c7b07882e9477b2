"""Direct numerical simulation: how a disturbed train evolves, or any cells in any surroundings.

What was recorded of a simulation, methods' settings and disturbances need no JAX; what steps cells
is imported when it is asked for.
"""

from typing import TYPE_CHECKING

from celltrain.evolution.disturbances import (
    Disturbance,
    FastestAtFirst,
    FromFile,
    Leading,
    NumberedMode,
    RandomDisplacement,
)
from celltrain.evolution.ending import Ending, StepFailed
from celltrain.evolution.films.repulsion import Repulsion
from celltrain.evolution.linear import LinearPrediction, linear_prediction
from celltrain.evolution.methods import (
    Automatic,
    ExponentialAdams,
    ForwardEuler,
    Integrator,
    RungeKuttaChebyshev,
)
from celltrain.evolution.record.run import Run
from celltrain.later import imported_later

if TYPE_CHECKING:
    from celltrain.evolution.cells import CellsInFlow, Snapshot, follow
    from celltrain.evolution.march import Status
    from celltrain.evolution.simulate import evolve, resume

__all__ = [
    "Automatic",
    "CellsInFlow",
    "Disturbance",
    "Ending",
    "ExponentialAdams",
    "FastestAtFirst",
    "ForwardEuler",
    "FromFile",
    "Integrator",
    "Leading",
    "LinearPrediction",
    "NumberedMode",
    "RandomDisplacement",
    "Repulsion",
    "Run",
    "RungeKuttaChebyshev",
    "Snapshot",
    "Status",
    "StepFailed",
    "evolve",
    "follow",
    "linear_prediction",
    "resume",
]

__getattr__ = imported_later(
    __name__,
    {
        "cells": ("CellsInFlow", "Snapshot", "follow"),
        "march": ("Status",),
        "simulate": ("evolve", "resume"),
    },
    "simulations",
)
