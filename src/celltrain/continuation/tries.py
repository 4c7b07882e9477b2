"""Tries of a search for steady trains, by a train's own flow or by Newton's method with deflation.

The flow from a guess leads mostly to the known train; Newton's method, which ends the march, may
lead to another one near by, a stable one or not. Newton's method with the known trains deflated
(see `deflation`) leads to others, too. Each try is bounded in steps. Guesses are passed by, and by
deflation all shapes, whose evaluation takes many times that of the known train: they all but touch
the wall or each other or are drawn out far beyond a cell.
"""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from celltrain.continuation.arclength import Evaluation, NoSolution, Unknowns
from celltrain.continuation.deflation import Tries, deflated_newton
from celltrain.continuation.equations import SteadyPoint, evaluate_steady, to_unknowns
from celltrain.harmonics import Profile
from celltrain.proximity.meridian import crosses_itself
from celltrain.quantities import Quantity, Record
from celltrain.steady import Base
from celltrain.steady.iterate import march

# Two trains nearer than this, in a/sqrt(4 pi), are the same (r0).
SAME = 1e-4
# Shapes that take more than this many times what the known train takes are passed by.
MOST_WORK = 16
# How tries are called that led to a root which is known, or the shape of no cell.
BACK, CROSSED = "came back to a known one", "found a shape that crosses itself"
# How marches are called that do not end at a steady train.
ASTRAY = {
    "iterations": "the flow became steady nowhere",
    "step": "the flow led to where no step goes on",
    "overlap": "the guess has no room",
    "no number": "the flow led to no numbers",
}


@dataclass(frozen=True, eq=False)
class SearchTry(Record):
    """One try: the guess and the way from it, how it ended, and the train if it has led to one."""

    guess: Annotated[str, Quantity("", "1", "what it started from")]
    way: Annotated[str, Quantity("", "1", "how it went on from there: flow or deflation")]
    steps: Annotated[int, Quantity("", "1", "steps of the march or of Newton's method")]
    seconds: Annotated[float, Quantity("", "s", "time that it took")]
    outcome: Annotated[str, Quantity("", "1", "how it ended")]
    residual: Annotated[float, Quantity("", "U", "residual at the end, NaN if there was none")]
    base: Annotated[Base | None, Quantity("", "1", "the train it led to", bulky=True)]


#: A try, and the root that it found if it is another one.
Tried = tuple[SearchTry, Unknowns | None]


def by_flow(
    name: str, profile: Profile, known: SteadyPoint, roots: Sequence[Unknowns], tries: Tries
) -> Tried:
    """From a guess along the train's own flow, in implicit steps (see `steady.iterate`)."""
    begun = time.perf_counter()

    def ended(outcome: str, steps: int, residual: float, base: Base | None = None) -> SearchTry:
        seconds = time.perf_counter() - begun
        return SearchTry(name, "flow", steps, seconds, outcome, residual, base)

    if not known.problem.fits(profile):
        return ended(ASTRAY["overlap"], 0, math.nan), None
    if known.problem.rules(profile).work > MOST_WORK * known.state.flow.rules.work:
        return ended("cells all but touch, or are drawn out too far", 0, math.nan), None
    # Forces on the wildest shapes are no numbers, which end the march.
    with np.errstate(over="ignore", invalid="ignore"):
        found = march(known.problem, profile, tolerance=tries.tolerance, most=tries.most_flow_steps)
    steps, residual = len(found.history), found.state.residual
    if not found.steady:
        return ended(ASTRAY[found.outcome], steps, residual), None
    point = SteadyPoint(known.problem, found.state)
    outcome, root, base = _told(
        point, to_unknowns(found.state.profile), roots, f"the flow from {name}"
    )
    return ended(outcome, steps, residual, base), root


def by_deflation(
    name: str, profile: Profile, known: SteadyPoint, roots: Sequence[Unknowns], tries: Tries
) -> Tried:
    """From a guess by Newton's method with all known roots deflated."""
    begun = time.perf_counter()

    def ended(outcome: str, steps: int, residual: float, base: Base | None = None) -> SearchTry:
        seconds = time.perf_counter() - begun
        return SearchTry(name, "deflation", steps, seconds, outcome, residual, base)

    start = to_unknowns(profile)
    if _apart(start, roots) < SAME:
        return ended("the guess is a known train", 0, math.nan), None
    most = MOST_WORK * known.state.flow.rules.work

    def equations(unknowns: Unknowns, near: SteadyPoint) -> Evaluation[SteadyPoint]:
        return evaluate_steady(near.problem, unknowns, near, most_work=most)

    try:
        # Forces on the wildest shapes are no numbers, which no step takes for a fall.
        with np.errstate(over="ignore", invalid="ignore"):
            attempt = deflated_newton(equations, start, known, roots, tries)
    except NoSolution as failure:
        return ended(str(failure), 0, math.nan), None
    error = attempt.evaluation.error
    if not attempt.converged:
        return ended(attempt.reason, attempt.steps, error), None
    point = attempt.evaluation.state
    outcome, root, base = _told(
        point, attempt.unknowns, roots, f"a search by deflation from {name}"
    )
    return ended(outcome, attempt.steps, error, base), root


def _told(
    point: SteadyPoint, root: Unknowns, roots: Sequence[Unknowns], origin: str
) -> tuple[str, Unknowns | None, Base | None]:
    """What a root is, the root if it is another one, and the train if it is the shape of a cell."""
    if _apart(root, roots) < SAME:
        return BACK, None, None
    if crosses_itself(point.state.profile):
        return CROSSED, root, None
    return "found another train", root, point.base(origin)


def _apart(unknowns: Unknowns, roots: Sequence[Unknowns]) -> float:
    return min(float(np.linalg.norm(unknowns - root)) for root in roots)
