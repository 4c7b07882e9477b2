"""Real orthonormal spherical harmonics, their grids and rotations."""

from celltrain.harmonics.basis import (
    HarmonicTables,
    coefficient_index,
    degrees_and_orders,
    harmonic_tables,
    real_harmonics,
    shift_longitude,
    unshift_longitude,
)
from celltrain.harmonics.grid import SphereGrid, sphere_grid, unit_vectors
from celltrain.harmonics.polar import (
    PolarTables,
    about_pole,
    polar_nodes,
    polar_rotation,
    polar_tables,
)
from celltrain.harmonics.rotation import PoleRotation, pole_rotation, turn_longitude

__all__ = [
    "HarmonicTables",
    "PolarTables",
    "PoleRotation",
    "SphereGrid",
    "about_pole",
    "coefficient_index",
    "degrees_and_orders",
    "harmonic_tables",
    "polar_nodes",
    "polar_rotation",
    "polar_tables",
    "pole_rotation",
    "real_harmonics",
    "shift_longitude",
    "sphere_grid",
    "turn_longitude",
    "unit_vectors",
    "unshift_longitude",
]
