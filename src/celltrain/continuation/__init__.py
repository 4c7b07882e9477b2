"""Following solutions: branches of steady trains, and the boundary of their stability."""

from celltrain.continuation.arclength import (
    CurveLost,
    CurvePoint,
    Ending,
    Evaluation,
    NoSolution,
    Steps,
    trace_curve,
)
from celltrain.continuation.boundary import (
    BoundaryPoint,
    StabilityBoundary,
    follow_boundary,
    stability_boundary,
)
from celltrain.continuation.branch import (
    Branch,
    BranchPoint,
    branch,
    check_branch,
    follow_branch,
)
from celltrain.continuation.deflation import (
    Attempt,
    Search,
    deflated_newton,
    deflated_step,
    further_trains,
)

__all__ = [
    "Attempt",
    "BoundaryPoint",
    "Branch",
    "BranchPoint",
    "CurveLost",
    "CurvePoint",
    "Ending",
    "Evaluation",
    "NoSolution",
    "Search",
    "StabilityBoundary",
    "Steps",
    "branch",
    "check_branch",
    "deflated_newton",
    "deflated_step",
    "follow_boundary",
    "follow_branch",
    "further_trains",
    "stability_boundary",
    "trace_curve",
]
