"""Pictures of results, drawn with Matplotlib and without its global state."""

from celltrain.pictures.dispersion import draw_dispersion
from celltrain.pictures.neighbours import draw_growth_without_neighbours
from celltrain.pictures.parameters import draw_parameter_sensitivities
from celltrain.pictures.plot import plot_all
from celltrain.pictures.profile import draw_profile
from celltrain.pictures.pseudospectrum import draw_pseudospectrum
from celltrain.pictures.sensitivity import draw_structural_sensitivity
from celltrain.pictures.spectrum import draw_spectrum
from celltrain.pictures.streamlines import draw_streamlines
from celltrain.pictures.train import draw_base_train, draw_leading_mode, draw_transient_mode
from celltrain.pictures.transient import draw_transient_growth

__all__ = [
    "draw_base_train",
    "draw_dispersion",
    "draw_growth_without_neighbours",
    "draw_leading_mode",
    "draw_parameter_sensitivities",
    "draw_profile",
    "draw_pseudospectrum",
    "draw_spectrum",
    "draw_streamlines",
    "draw_structural_sensitivity",
    "draw_transient_growth",
    "draw_transient_mode",
    "plot_all",
]
