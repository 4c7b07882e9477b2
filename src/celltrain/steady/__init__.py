"""Steady trains."""

from celltrain.steady.base import Base, Iteration, NotConverged
from celltrain.steady.solve import change_degree, steady
from celltrain.steady.velocity import fluid_velocity

__all__ = ["Base", "Iteration", "NotConverged", "change_degree", "fluid_velocity", "steady"]
