"""Tries of a search for steady trains, by a train's own flow or by Newton's method with deflation.

The flow from a guess leads mostly to the known train; Newton's method, which ends the march, may
lead to another one near by, a stable one or not. Newton's method with the known trains deflated
(see `deflation`) leads to others, too. Each try is bounded in steps. Guesses are passed by, and by
deflation all shapes, whose evaluation takes many times that of the known train: they all but touch
the wall or each other or are drawn out far beyond a cell.
"""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
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


@dataclass(frozen=True)
class _End:
    """Where a try has ended."""

    outcome: str
    steps: int = 0
    residual: float = math.nan
    root: Unknowns | None = None
    base: Base | None = None


def by_flow(
    name: str, profile: Profile, known: SteadyPoint, roots: Sequence[Unknowns], tries: Tries
) -> Tried:
    """From a guess along the train's own flow, in implicit steps (see `steady.iterate`)."""
    return _timed(_marched, "flow", name, profile, known, roots, tries)


def by_deflation(
    name: str, profile: Profile, known: SteadyPoint, roots: Sequence[Unknowns], tries: Tries
) -> Tried:
    """From a guess by Newton's method with all known roots deflated."""
    return _timed(_deflated, "deflation", name, profile, known, roots, tries)


def _timed(
    going: Callable[[Profile, SteadyPoint, Sequence[Unknowns], Tries], _End],
    way: str,
    name: str,
    profile: Profile,
    known: SteadyPoint,
    roots: Sequence[Unknowns],
    tries: Tries,
) -> Tried:
    begun = time.perf_counter()
    # Forces on the wildest shapes are no numbers, which end a march and shorten a step.
    with np.errstate(over="ignore", invalid="ignore"):
        end = going(profile, known, roots, tries)
    base = None if end.base is None else replace(end.base, origin=f"a search by {way} from {name}")
    seconds = time.perf_counter() - begun
    return SearchTry(name, way, end.steps, seconds, end.outcome, end.residual, base), end.root


def _marched(profile: Profile, known: SteadyPoint, roots: Sequence[Unknowns], tries: Tries) -> _End:
    problem = known.problem
    if not problem.fits(profile):
        return _End(ASTRAY["overlap"])
    if problem.rules(profile).work > MOST_WORK * known.state.flow.rules.work:
        return _End("cells all but touch, or are drawn out too far")
    found = march(problem, profile, tolerance=tries.tolerance, most=tries.most_flow_steps)
    steps, residual = len(found.history), found.state.residual
    if not found.steady:
        return _End(ASTRAY[found.outcome], steps, residual)
    root = to_unknowns(found.state.profile)
    return _told(SteadyPoint(problem, found.state), root, roots, steps, residual)


def _deflated(
    profile: Profile, known: SteadyPoint, roots: Sequence[Unknowns], tries: Tries
) -> _End:
    start = to_unknowns(profile)
    if _apart(start, roots) < SAME:
        return _End("the guess is a known train")
    most = MOST_WORK * known.state.flow.rules.work

    def equations(unknowns: Unknowns, near: SteadyPoint) -> Evaluation[SteadyPoint]:
        return evaluate_steady(near.problem, unknowns, near, most_work=most)

    try:
        attempt = deflated_newton(equations, start, known, roots, tries)
    except NoSolution as failure:
        return _End(str(failure))
    point, error = attempt.evaluation.state, attempt.evaluation.error
    if not attempt.converged:
        return _End(attempt.reason, attempt.steps, error)
    return _told(point, attempt.unknowns, roots, attempt.steps, error)


def _told(
    point: SteadyPoint, root: Unknowns, roots: Sequence[Unknowns], steps: int, residual: float
) -> _End:
    """What a root is, the root if it is another one, and the train if it is the shape of a cell."""
    if _apart(root, roots) < SAME:
        return _End(BACK, steps, residual)
    if crosses_itself(point.state.profile):
        return _End(CROSSED, steps, residual, root)
    return _End("found another train", steps, residual, root, point.base(""))


def _apart(unknowns: Unknowns, roots: Sequence[Unknowns]) -> float:
    return min(float(np.linalg.norm(unknowns - root)) for root in roots)
