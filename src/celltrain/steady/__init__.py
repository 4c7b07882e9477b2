"""Steady trains."""

from celltrain.steady.base import Base, Iteration, NotConverged
from celltrain.steady.solve import steady

__all__ = ["Base", "Iteration", "NotConverged", "steady"]
