"""Following solutions: branches of steady trains, and the boundary of their stability."""

from celltrain.continuation.arclength import (
    CurveEnding,
    CurveLost,
    CurvePoint,
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
from celltrain.continuation.deflation import Attempt, Tries, deflated_newton
from celltrain.continuation.search import (
    BranchSearch,
    FoundTrain,
    search_trains,
)
from celltrain.continuation.tries import SearchTry

__all__ = [
    "Attempt",
    "BoundaryPoint",
    "Branch",
    "BranchPoint",
    "BranchSearch",
    "CurveEnding",
    "CurveLost",
    "CurvePoint",
    "Evaluation",
    "FoundTrain",
    "NoSolution",
    "SearchTry",
    "StabilityBoundary",
    "Steps",
    "Tries",
    "branch",
    "check_branch",
    "deflated_newton",
    "follow_boundary",
    "follow_branch",
    "search_trains",
    "stability_boundary",
    "trace_curve",
]
