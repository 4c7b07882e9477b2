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

__all__ = [
    "BoundaryPoint",
    "Branch",
    "BranchPoint",
    "CurveLost",
    "CurvePoint",
    "Ending",
    "Evaluation",
    "NoSolution",
    "StabilityBoundary",
    "Steps",
    "branch",
    "check_branch",
    "follow_boundary",
    "follow_branch",
    "stability_boundary",
    "trace_curve",
]
