"""Which errors of a step are allowed, and how steps follow estimates of them of second order."""

import math

import numpy as np

from celltrain.evolution.ending import StepFailed
from celltrain.evolution.methods.integrator import CellDynamics, Work
from celltrain.evolution.state import State
from celltrain.harmonics import Shapes

# Distance from the steady train (r0) below and above which errors are measured by these.
SMALLEST_SCALE = 1e-6
LARGEST_SCALE = 1.0
# Largest error of a step over the thinnest film within the range of the repulsion.
GAP_SHARE = 0.1
# Allowed correction of volumes (r0) after a step over the tolerance: the paper's 1e-5 r0 at 1e-3.
# Allowed at any tolerance: a part of it is proportional to the step, from the flow through a
# membrane that quadrature leaves.
VOLUME_SHARE = 0.01
SMALLEST_CORRECTION = 1e-6
# What part of the step that this allows is taken next: unlike errors, corrections vary little.
VOLUME_SAFETY = 0.95
# The next step: this part of what the error allows, between these factors of the last one.
SAFETY = 0.8
LEAST_FACTOR = 0.1
LARGEST_FACTOR = 10.0
#: Relative errors below this are taken as this: they say nothing about how errors grow.
SMALLEST_ERROR = 1e-4
#: The smallest step, r0/U.
SMALLEST_STEP = 1e-6
#: A step after which cells overlap is tried again with this part of it, down to a smallest one.
OVERLAP_FACTOR = 0.25
SMALLEST_RETRY = 1e-4


def allowed_error(dynamics: CellDynamics, state: State, shapes: Shapes, tolerance: float) -> float:
    """The displacement, in r0, that a step from a state may be wrong by; `shapes`: continuous."""
    distance = dynamics.departure(shapes)
    allowed = tolerance * min(max(distance, SMALLEST_SCALE), LARGEST_SCALE)
    return float(min(allowed, GAP_SHARE * state.measures.gap))


def with_volumes(relative: float, after: State, tolerance: float) -> tuple[float, bool]:
    """The relative error of a step that the next one follows, and whether this one is accepted.

    **Arguments:** `relative`: without regard to the correction of the volumes; NaN is not accepted.
    """
    allowed = max(VOLUME_SHARE * tolerance, SMALLEST_CORRECTION)
    corrected = after.measures.volume_correction / allowed
    followed = float(np.maximum(relative, (SAFETY / VOLUME_SAFETY) ** 3 * corrected))
    return followed, bool(relative <= 1.0 and corrected <= 1.0)


def step_factor(step: float, error: float, last_step: float, last_error: float) -> float:
    """The next step over this one, from the relative errors of this one and the one before.

    **Arguments:** `last_step`: 0 if there was none.
    """
    error = max(error, SMALLEST_ERROR)
    factor = SAFETY * error ** (-1.0 / 3.0)
    if last_step > 0.0:
        predicted = SAFETY * step / last_step * last_error ** (1.0 / 3.0)
        factor = min(factor, predicted * error ** (-2.0 / 3.0))
    return min(max(factor, LEAST_FACTOR), LARGEST_FACTOR)


def shorter_step(step: float, error: float, *, tolerance: float, work: Work) -> float:
    """The step to try after one whose relative error was too large or NaN.

    **Arguments:** `work`: what was tried in vain.

    **Raises:** `StepFailed` if it is too short.
    """
    finite = math.isfinite(error)
    factor = max(SAFETY * error ** (-1.0 / 3.0), LEAST_FACTOR) if finite else LEAST_FACTOR
    shorter = step * factor
    if shorter >= SMALLEST_STEP:
        return shorter
    if not finite:
        raise StepFailed("not_finite", "shapes or velocities have become NaN", **vars(work))
    message = f"the tolerance {tolerance:g} needs steps below {SMALLEST_STEP:g} r0/U"
    raise StepFailed("step_too_small", message, **vars(work))
