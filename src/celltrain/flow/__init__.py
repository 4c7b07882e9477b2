"""Stokes flow around cells, in a periodic tube or in unbounded space.

Ewald sums, quadrature on surfaces, the wall, the flow rate.
"""

from celltrain.extras import check_installed

check_installed("simulations")

# ruff: noqa: E402
from celltrain.flow.ewald import EwaldSplit, ewald_split
from celltrain.flow.own_surface import OwnSurfaceRule, own_surface_rule
from celltrain.flow.sources import Sources
from celltrain.flow.surrounding_flow import SurroundingFlow
from celltrain.flow.tube import PeriodicTube, periodic_tube
from celltrain.flow.unbounded import UnboundedFlow, unbounded_flow
from celltrain.flow.wall import TubeWall, tube_wall

__all__ = [
    "EwaldSplit",
    "OwnSurfaceRule",
    "PeriodicTube",
    "Sources",
    "SurroundingFlow",
    "TubeWall",
    "UnboundedFlow",
    "ewald_split",
    "own_surface_rule",
    "periodic_tube",
    "tube_wall",
    "unbounded_flow",
]
