"""Pictures of results, drawn with Matplotlib and without its global state."""

from celltrain.pictures.continuation import draw_branch, draw_search, draw_stability_boundary
from celltrain.pictures.dispersion import draw_dispersion
from celltrain.pictures.error_bars import draw_error_bars
from celltrain.pictures.mechanisms import (
    draw_deformation_spectra,
    draw_mode_motions,
    draw_strain_energies,
)
from celltrain.pictures.neighbours import draw_growth_without_neighbours
from celltrain.pictures.profile import draw_profile
from celltrain.pictures.pseudospectrum import draw_pseudospectrum
from celltrain.pictures.sensitivity import draw_parameter_sensitivities, draw_structural_sensitivity
from celltrain.pictures.spectrum import draw_spectrum
from celltrain.pictures.streamlines import draw_streamlines
from celltrain.pictures.train import draw_base_train, draw_leading_mode, draw_transient_mode
from celltrain.pictures.transient import draw_transient_growth

__all__ = [
    "draw_base_train",
    "draw_branch",
    "draw_deformation_spectra",
    "draw_dispersion",
    "draw_error_bars",
    "draw_growth_without_neighbours",
    "draw_leading_mode",
    "draw_mode_motions",
    "draw_parameter_sensitivities",
    "draw_profile",
    "draw_pseudospectrum",
    "draw_search",
    "draw_spectrum",
    "draw_stability_boundary",
    "draw_strain_energies",
    "draw_streamlines",
    "draw_structural_sensitivity",
    "draw_transient_growth",
    "draw_transient_mode",
]
