"""Steady trains."""

from celltrain.steady.base import Base, Iteration, NotConverged
from celltrain.steady.sensitivity import BaseSensitivity, base_sensitivities
from celltrain.steady.solve import change_degree, steady
from celltrain.steady.velocity import fluid_velocity

__all__ = [
    "Base",
    "BaseSensitivity",
    "Iteration",
    "NotConverged",
    "base_sensitivities",
    "change_degree",
    "fluid_velocity",
    "steady",
]
