"""Steady trains."""

from celltrain.steady.base import Base, Iteration, NotConverged
from celltrain.steady.sensitivity import BaseSensitivity, base_sensitivities
from celltrain.steady.solve import steady

__all__ = [
    "Base",
    "BaseSensitivity",
    "Iteration",
    "NotConverged",
    "base_sensitivities",
    "steady",
]
