"""What is measured of simulated cells: moments, motion, energies, distances, by frame."""

from celltrain.diagnostics.distance import cell_distance, wall_distance
from celltrain.diagnostics.ellipsoid import Ellipsoid, best_ellipsoid
from celltrain.diagnostics.energy import ENERGY_PARTS, energy_parts, perturbation_energy
from celltrain.diagnostics.fields import SurfaceFields, surface_fields
from celltrain.diagnostics.frame import frame
from celltrain.diagnostics.haematocrit import (
    discharge_haematocrit,
    in_vitro_viscosity,
    tube_haematocrit,
)
from celltrain.diagnostics.modes import ModeMotion, mode_motion
from celltrain.diagnostics.moments import CellMoments, cell_moments
from celltrain.diagnostics.quantities import FRAME_QUANTITIES, FrameQuantity
from celltrain.diagnostics.rotation import CellMotion, cell_motion
from celltrain.diagnostics.spectrum import deformation_spectrum, disturbance_amplitude
from celltrain.diagnostics.streamlines import (
    MeridionalFlow,
    Recirculation,
    meridional_flow,
    recirculation,
)
from celltrain.diagnostics.tension import isotropic_tension

__all__ = [
    "ENERGY_PARTS",
    "FRAME_QUANTITIES",
    "CellMoments",
    "CellMotion",
    "Ellipsoid",
    "FrameQuantity",
    "MeridionalFlow",
    "ModeMotion",
    "Recirculation",
    "SurfaceFields",
    "best_ellipsoid",
    "cell_distance",
    "cell_moments",
    "cell_motion",
    "deformation_spectrum",
    "discharge_haematocrit",
    "disturbance_amplitude",
    "energy_parts",
    "frame",
    "in_vitro_viscosity",
    "isotropic_tension",
    "meridional_flow",
    "mode_motion",
    "perturbation_energy",
    "recirculation",
    "surface_fields",
    "tube_haematocrit",
    "wall_distance",
]
