"""Linear stability of steady trains."""

from celltrain.stability.adjoint import (
    NEAR_DOUBLE,
    StructuralSensitivity,
    biorthogonality_error,
    condition_number,
    leading_condition,
    mode_vectors,
    receptivity,
    structural_sensitivity,
)
from celltrain.stability.analysis import stability
from celltrain.stability.convergence import (
    ACCURACY,
    NUMBERS,
    check_accuracy,
    check_linearisable,
)
from celltrain.stability.coordinates import NormedBlock, normed_block, normed_blocks
from celltrain.stability.error_bars import check_count, with_error_bars
from celltrain.stability.infinite import (
    InfiniteTrain,
    WaveMode,
    distance_to_uniform,
    infinite_train,
)
from celltrain.stability.linearise import linear_blocks
from celltrain.stability.neighbours import (
    GrowthWithout,
    blocks_without_neighbours,
    growth_without_neighbours,
)
from celltrain.stability.neutral import (
    NeutralDefect,
    NeutralSpace,
    deflated,
    neutral_defects,
    neutral_space,
)
from celltrain.stability.norms import (
    NORMS,
    Norm,
    OrthonormalNorm,
    PaperNorm,
    SurfaceNorm,
    paper_weights,
)
from celltrain.stability.parameter_sensitivity import (
    ParameterSensitivities,
    ParameterSensitivity,
    parameter_sensitivities,
    wave_sensitivities,
)
from celltrain.stability.pseudospectrum import (
    Kreiss,
    Pseudospectrum,
    Window,
    kreiss_constant,
    pseudospectrum,
)
from celltrain.stability.result import ErrorBar, Mode, Stability, TransientMode
from celltrain.stability.spectrum import block_spectrum, numerical_abscissa
from celltrain.stability.strain_norm import StrainNorm, second_variation
from celltrain.stability.transient import (
    BlockGrowth,
    OptimalDisturbance,
    Peak,
    TransientGrowth,
    optimal_disturbance,
    propagator_norm,
    transient_growth,
)

__all__ = [
    "ACCURACY",
    "NEAR_DOUBLE",
    "NORMS",
    "NUMBERS",
    "BlockGrowth",
    "ErrorBar",
    "GrowthWithout",
    "InfiniteTrain",
    "Kreiss",
    "Mode",
    "NeutralDefect",
    "NeutralSpace",
    "Norm",
    "NormedBlock",
    "OptimalDisturbance",
    "OrthonormalNorm",
    "PaperNorm",
    "ParameterSensitivities",
    "ParameterSensitivity",
    "Peak",
    "Pseudospectrum",
    "Stability",
    "StrainNorm",
    "StructuralSensitivity",
    "SurfaceNorm",
    "TransientGrowth",
    "TransientMode",
    "WaveMode",
    "Window",
    "biorthogonality_error",
    "block_spectrum",
    "blocks_without_neighbours",
    "check_accuracy",
    "check_count",
    "check_linearisable",
    "condition_number",
    "deflated",
    "distance_to_uniform",
    "growth_without_neighbours",
    "infinite_train",
    "kreiss_constant",
    "leading_condition",
    "linear_blocks",
    "mode_vectors",
    "neutral_defects",
    "neutral_space",
    "normed_block",
    "normed_blocks",
    "numerical_abscissa",
    "optimal_disturbance",
    "paper_weights",
    "parameter_sensitivities",
    "propagator_norm",
    "pseudospectrum",
    "receptivity",
    "second_variation",
    "stability",
    "structural_sensitivity",
    "transient_growth",
    "wave_sensitivities",
    "with_error_bars",
]
