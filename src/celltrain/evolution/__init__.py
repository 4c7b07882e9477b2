"""Direct numerical simulation: how a disturbed train evolves, or any cells in any surroundings.

What was recorded of a simulation, methods' settings and disturbances need no JAX; what steps cells
is imported when it is asked for.
"""

from importlib import import_module
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
from celltrain.evolution.methods import ForwardEuler, Integrator, RungeKuttaChebyshev
from celltrain.evolution.record.run import Run
from celltrain.extras import check_installed

if TYPE_CHECKING:
    from celltrain.evolution.cells import CellsInFlow, Snapshot, follow
    from celltrain.evolution.march import Status
    from celltrain.evolution.simulate import evolve, resume

__all__ = [
    "CellsInFlow",
    "Disturbance",
    "Ending",
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

_LATER = {
    "cells": ("CellsInFlow", "Snapshot", "follow"),
    "march": ("Status",),
    "simulate": ("evolve", "resume"),
}
_OWNERS = {name: owner for owner, names in _LATER.items() for name in names}


def __getattr__(name: str) -> object:
    if name not in _OWNERS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    check_installed("simulations")
    return getattr(import_module(f"{__name__}.{_OWNERS[name]}"), name)
