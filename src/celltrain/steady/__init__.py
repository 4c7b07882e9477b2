"""Steady trains."""

from celltrain.steady.base import Base, Iteration, NotConverged
from celltrain.steady.solve import change_degree, steady

__all__ = ["Base", "Iteration", "NotConverged", "change_degree", "steady"]
