"""Linear stability of steady trains."""

from celltrain.stability.analysis import check_linearisable, neutral_space, stability
from celltrain.stability.full_matrix import (
    Derivative,
    ExactDerivative,
    FiniteDifference,
    full_matrix,
)
from celltrain.stability.linearise import linear_blocks
from celltrain.stability.norms import NORMS, Norm, OrthonormalNorm, PaperNorm, SurfaceNorm
from celltrain.stability.result import Mode, Stability, TransientMode
from celltrain.stability.spectrum import block_spectrum, numerical_abscissa

__all__ = [
    "NORMS",
    "Derivative",
    "ExactDerivative",
    "FiniteDifference",
    "Mode",
    "Norm",
    "OrthonormalNorm",
    "PaperNorm",
    "Stability",
    "SurfaceNorm",
    "TransientMode",
    "block_spectrum",
    "check_linearisable",
    "full_matrix",
    "linear_blocks",
    "neutral_space",
    "numerical_abscissa",
    "stability",
]
