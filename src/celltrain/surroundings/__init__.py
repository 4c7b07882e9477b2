"""What is around cells of any shape: a tube, or unbounded space with a linear background flow."""

from celltrain.extras import check_installed

check_installed("simulations")

# ruff: noqa: E402
from celltrain.surroundings.round_tube import RoundTube, train_tube
from celltrain.surroundings.surroundings import FlowRules, Surroundings
from celltrain.surroundings.unbounded_space import UnboundedSpace, simple_shear

__all__ = [
    "FlowRules",
    "RoundTube",
    "Surroundings",
    "UnboundedSpace",
    "simple_shear",
    "train_tube",
]
