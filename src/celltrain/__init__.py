"""Trains of red blood cells in narrow tubes: their steady flow and its stability.

    from celltrain import Train, steady, stability

    train = Train(diameter=6, packing=0.2, cells=8)
    base = steady(train)
    result = stability(base)
    result.spectral_abscissa

Lengths are in r0 (radius of the sphere of a cell's volume), velocities in U (mean velocity in the
tube), viscosities in mu (plasma); so rates are in U/r0. 64-bit floats are switched on for JAX when
the package is imported.
"""

import celltrain.runtime  # noqa: F401  (first: settings of JAX)
from celltrain.evolution import Run, evolve, resume
from celltrain.parameters import CaseError, Train, load_case, paper_units
from celltrain.results import load, print_report, save, summary
from celltrain.stability import Mode, Stability, stability
from celltrain.steady import Base, NotConverged, fluid_velocity, steady

__version__ = "0.1.0"

__all__ = [
    "Base",
    "CaseError",
    "Mode",
    "NotConverged",
    "Run",
    "Stability",
    "Train",
    "evolve",
    "fluid_velocity",
    "load",
    "load_case",
    "paper_units",
    "print_report",
    "resume",
    "save",
    "stability",
    "steady",
    "summary",
]
