"""The cell membrane: reference shapes, metric and curvature, elastic energy and its force."""

from celltrain.membrane.bending import (
    BendingLaw,
    ElasticBending,
    HelfrichBending,
    make_bending,
)
from celltrain.membrane.energy import Membrane, make_membrane
from celltrain.membrane.equilibrium import healthy_reduced_volume, relaxed_slope
from celltrain.membrane.geometry import SurfaceGeometry, surface_geometry, volume
from celltrain.membrane.laws import ConstitutiveLaw, NeoHookean, Skalak, make_law
from celltrain.membrane.reference import reference_coefficients
from celltrain.membrane.resting import resting_shape

__all__ = [
    "BendingLaw",
    "ConstitutiveLaw",
    "ElasticBending",
    "HelfrichBending",
    "Membrane",
    "NeoHookean",
    "Skalak",
    "SurfaceGeometry",
    "healthy_reduced_volume",
    "make_bending",
    "make_law",
    "make_membrane",
    "reference_coefficients",
    "relaxed_slope",
    "resting_shape",
    "surface_geometry",
    "volume",
]
