"""Real orthonormal spherical harmonics, their grids and rotations."""

from celltrain.harmonics.basis import (
    HarmonicTables,
    coefficient_index,
    degrees_and_orders,
    harmonic_tables,
    real_harmonics,
    shift_longitude,
)
from celltrain.harmonics.grid import SphereGrid, polar_rule, sphere_grid

__all__ = [
    "HarmonicTables",
    "SphereGrid",
    "coefficient_index",
    "degrees_and_orders",
    "harmonic_tables",
    "polar_rule",
    "real_harmonics",
    "shift_longitude",
    "sphere_grid",
]
