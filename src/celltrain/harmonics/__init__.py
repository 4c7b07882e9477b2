"""Real orthonormal spherical harmonics, their grids and rotations.

What is here needs NumPy only. The parts for JAX are modules of their own: `tables` and `grid` (the
harmonics at fixed points), `longitude`, `rotation` and `polar` (functions turned, and seen from
other poles), and `jax_shapes` (what arrays of shapes are called there).
"""

from celltrain.harmonics.azimuthal import azimuthal_weight, cylindrical_members, member_count
from celltrain.harmonics.basis import coefficient_index, degrees_and_orders, real_harmonics
from celltrain.harmonics.families import (
    axisymmetric_basis,
    azimuthal_basis,
    azimuthal_families,
    both_families,
)
from celltrain.harmonics.legendre import LegendreTables, legendre_functions, legendre_tables
from celltrain.harmonics.nodes import about_pole, gauss_colatitudes, polar_nodes, unit_vectors
from celltrain.harmonics.profile import Profile, coefficients_of, profile_of, project_meridian
from celltrain.harmonics.shapes import (
    UNIT_DISPLACEMENT,
    Shape,
    Shapes,
    degree_of,
    displaced,
    displaced_along,
    mean_points,
    surface_points,
)

__all__ = [
    "UNIT_DISPLACEMENT",
    "LegendreTables",
    "Profile",
    "Shape",
    "Shapes",
    "about_pole",
    "axisymmetric_basis",
    "azimuthal_basis",
    "azimuthal_families",
    "azimuthal_weight",
    "both_families",
    "coefficient_index",
    "coefficients_of",
    "cylindrical_members",
    "degree_of",
    "degrees_and_orders",
    "displaced",
    "displaced_along",
    "gauss_colatitudes",
    "legendre_functions",
    "legendre_tables",
    "mean_points",
    "member_count",
    "polar_nodes",
    "profile_of",
    "project_meridian",
    "real_harmonics",
    "surface_points",
    "unit_vectors",
]
