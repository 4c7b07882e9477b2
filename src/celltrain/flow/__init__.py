"""Stokes flow in a periodic tube: Ewald sums, quadrature on surfaces, the wall, the flow rate."""

from celltrain.extras import check_installed

check_installed("simulations")

# ruff: noqa: E402
from celltrain.flow.ewald import EwaldSplit, ewald_split
from celltrain.flow.own_surface import OwnSurfaceRule, own_surface_rule
from celltrain.flow.sources import Sources
from celltrain.flow.tube import PeriodicTube, periodic_tube
from celltrain.flow.wall import TubeWall, tube_wall

__all__ = [
    "EwaldSplit",
    "OwnSurfaceRule",
    "PeriodicTube",
    "Sources",
    "TubeWall",
    "ewald_split",
    "own_surface_rule",
    "periodic_tube",
    "tube_wall",
]
