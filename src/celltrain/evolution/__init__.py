"""Direct numerical simulation: how a disturbed train evolves."""

from celltrain.evolution.disturbances import (
    Disturbance,
    FromFile,
    Leading,
    Mode,
    RandomDisplacement,
    Transient,
)
from celltrain.evolution.ending import Ending
from celltrain.evolution.euler import ForwardEuler
from celltrain.evolution.evolve import evolve, resume
from celltrain.evolution.integrator import Integrator, StepFailed
from celltrain.evolution.linear import LinearPrediction, linear_prediction
from celltrain.evolution.march import Status
from celltrain.evolution.repulsion import Repulsion
from celltrain.evolution.run import Run
from celltrain.evolution.runge_kutta_chebyshev import RungeKuttaChebyshev

__all__ = [
    "Disturbance",
    "Ending",
    "ForwardEuler",
    "FromFile",
    "Integrator",
    "Leading",
    "LinearPrediction",
    "Mode",
    "RandomDisplacement",
    "Repulsion",
    "Run",
    "RungeKuttaChebyshev",
    "Status",
    "StepFailed",
    "Transient",
    "evolve",
    "linear_prediction",
    "resume",
]
