"""The cell membrane: reference shapes, metric and curvature, elastic energy and its force."""

from celltrain.membrane.energy import Membrane, make_membrane
from celltrain.membrane.geometry import SurfaceGeometry, surface_geometry, volume
from celltrain.membrane.laws import ConstitutiveLaw, NeoHookean, Skalak
from celltrain.membrane.reference import reference_coefficients

__all__ = [
    "ConstitutiveLaw",
    "Membrane",
    "NeoHookean",
    "Skalak",
    "SurfaceGeometry",
    "make_membrane",
    "reference_coefficients",
    "surface_geometry",
    "volume",
]
