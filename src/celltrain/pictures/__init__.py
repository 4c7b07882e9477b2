"""Pictures of results, drawn with Matplotlib and without its global state."""

from celltrain.pictures.plot import plot_all
from celltrain.pictures.profile import draw_profile
from celltrain.pictures.spectrum import draw_spectrum
from celltrain.pictures.train import draw_base_train, draw_leading_mode, draw_transient_mode

__all__ = [
    "draw_base_train",
    "draw_leading_mode",
    "draw_profile",
    "draw_spectrum",
    "draw_transient_mode",
    "plot_all",
]
