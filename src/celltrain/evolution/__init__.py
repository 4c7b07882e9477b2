"""Direct numerical simulation: how a disturbed train evolves, or any cells in any surroundings."""

from celltrain.extras import check_installed

check_installed("simulations")

# ruff: noqa: E402
from celltrain.evolution.cells import CellsInFlow, Snapshot, follow
from celltrain.evolution.disturbances import (
    Disturbance,
    FastestAtFirst,
    FromFile,
    Leading,
    NumberedMode,
    RandomDisplacement,
)
from celltrain.evolution.ending import Ending, StepFailed
from celltrain.evolution.evolve import evolve, resume
from celltrain.evolution.films import Repulsion
from celltrain.evolution.linear import LinearPrediction, linear_prediction
from celltrain.evolution.march import Status
from celltrain.evolution.methods import ForwardEuler, Integrator, RungeKuttaChebyshev
from celltrain.evolution.record.run import Run

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
