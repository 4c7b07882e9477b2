"""What is measured of simulated cells: moments, motion, energies, by frame.

Measures of steady trains and of modes need no JAX; what does is imported when it is asked for.
"""

from typing import TYPE_CHECKING

from celltrain.diagnostics.haematocrit import (
    discharge_haematocrit,
    in_vitro_fahraeus,
    in_vitro_viscosity,
    tube_haematocrit,
)
from celltrain.diagnostics.lubrication import lubricated, rigid_bullet, rigid_cell
from celltrain.diagnostics.mechanisms import Mechanisms, mechanisms
from celltrain.diagnostics.modes import ModeMotion, mode_motion
from celltrain.diagnostics.quantities import ENERGY_PARTS, FRAME_QUANTITIES
from celltrain.diagnostics.spectrum import deformation_spectrum, disturbance_amplitude
from celltrain.diagnostics.streamlines import (
    MeridionalFlow,
    Recirculation,
    meridional_flow,
    recirculation,
)
from celltrain.later import imported_later

if TYPE_CHECKING:
    from celltrain.diagnostics.ellipsoid import Ellipsoid, best_ellipsoid
    from celltrain.diagnostics.energy import energy_parts, perturbation_energy
    from celltrain.diagnostics.fields import SurfaceFields, surface_fields
    from celltrain.diagnostics.frames import frame
    from celltrain.diagnostics.moments import CellMoments, cell_moments
    from celltrain.diagnostics.rotation import CellMotion, cell_motion
    from celltrain.diagnostics.stresslet import stresslets
    from celltrain.diagnostics.tension import isotropic_tension

__all__ = [
    "ENERGY_PARTS",
    "FRAME_QUANTITIES",
    "CellMoments",
    "CellMotion",
    "Ellipsoid",
    "Mechanisms",
    "MeridionalFlow",
    "ModeMotion",
    "Recirculation",
    "SurfaceFields",
    "best_ellipsoid",
    "cell_moments",
    "cell_motion",
    "deformation_spectrum",
    "discharge_haematocrit",
    "disturbance_amplitude",
    "energy_parts",
    "frame",
    "in_vitro_fahraeus",
    "in_vitro_viscosity",
    "isotropic_tension",
    "lubricated",
    "mechanisms",
    "meridional_flow",
    "mode_motion",
    "perturbation_energy",
    "recirculation",
    "rigid_bullet",
    "rigid_cell",
    "stresslets",
    "surface_fields",
    "tube_haematocrit",
]

__getattr__ = imported_later(
    __name__,
    {
        "ellipsoid": ("Ellipsoid", "best_ellipsoid"),
        "energy": ("energy_parts", "perturbation_energy"),
        "fields": ("SurfaceFields", "surface_fields"),
        "frames": ("frame",),
        "moments": ("CellMoments", "cell_moments"),
        "rotation": ("CellMotion", "cell_motion"),
        "stresslet": ("stresslets",),
        "tension": ("isotropic_tension",),
    },
    "simulations",
)
