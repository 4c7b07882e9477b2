"""From one steady train to another, along a path of parameters.

All numbers in which two cases differ change together, in geometric proportion where both are
positive. The guess for the next train is extrapolated from the last two, and corrected by Newton's
method; a step that fails is halved, one that took few corrections is followed by a longer one. A
path ends early where its degree no longer follows the shapes, if it is told how to see that.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from celltrain.harmonics import Profile
from celltrain.parameters import Train
from celltrain.steady.base import Iteration, IterationProgress
from celltrain.steady.iterate import Iterated, least_room, newton
from celltrain.steady.problem import SteadyProblem

#: Shortest step, as a part of the whole path.
SMALLEST_PART = 1.0 / 256.0
# Newton's steps that one step along the path may take, and up to which the next one is longer.
MOST_CORRECTIONS, FEW_CORRECTIONS = 10, 4
# Trains on the way need not be exact.
LOOSE = 1e-6


@dataclass(frozen=True)
class Followed:
    """The last train of a path that was found, with the whole history, and if it is the end."""

    problem: SteadyProblem
    iterated: Iterated
    complete: bool


def follow(
    begin: Train,
    profile: Profile,
    end: Train,
    *,
    tolerance: float,
    most: int,
    first: float = 1.0,
    smallest: float = SMALLEST_PART,
    rough: float = math.inf,
    progress: IterationProgress | None = None,
) -> Followed:
    """The steady train of `end`, from that of `begin` with the given profile.

    **Arguments:** `tolerance`: bound on the residual; `most`: iterations in all; `first`,
    `smallest`: the first and the shortest step, as parts of the path; `rough`: the truncation
    error, U, above which a train on the way ends it.

    **Raises:** `CaseError` if a case on the way is not allowed.
    """
    at = SteadyProblem(begin)
    # Displacements from rest vary less than shapes where the cells themselves change.
    known = [(0.0, profile - at.rest)]
    history: list[Iteration] = []
    reached: tuple[SteadyProblem, Iterated] | None = None
    place, part, room = 0.0, first, at.room(profile)
    while True:
        following = min(1.0, place + part)
        problem = SteadyProblem(between(begin, end, following))
        guess = change_degree(_extrapolated(known, following), problem.degree) + problem.rest
        if (problem.room(guess) < least_room(room)).any() and part >= smallest:
            part *= 0.5
            continue
        found = newton(
            problem,
            guess,
            tolerance=tolerance if following == 1.0 else max(LOOSE, tolerance),
            most=min(MOST_CORRECTIONS, max(0, most - len(history))),
            progress=progress,
        )
        history += found.history
        if found.steady:
            reached = problem, found
            place = following
            room = problem.room(found.state.profile)
            known = [*known[-1:], (place, found.state.profile - problem.rest)]
            if len(found.history) <= FEW_CORRECTIONS:
                part *= 2.0
        else:
            part *= 0.5
        coarse = found.steady and found.state.truncation_error > rough
        if place == 1.0 or coarse or part < smallest or len(history) >= most:
            problem, found = reached or (problem, found)
            whole = Iterated(found.state, tuple(history), found.outcome)
            return Followed(problem, whole, place == 1.0)


def between(begin: Train, end: Train, place: float) -> Train:
    """The case at a place of the path, 0 to 1; what is no number is that of the end.

    **Raises:** `CaseError` if it is not allowed.
    """
    if place == 1.0:
        return end
    before, after = begin.leaves(), end.leaves()
    changes = {}
    for name, last in after.items():
        start = before[name]
        if start == last or not isinstance(start, float) or not isinstance(last, float):
            continue
        if start > 0.0 and last > 0.0:
            changes[name] = start ** (1.0 - place) * last**place
        else:
            changes[name] = (1.0 - place) * start + place * last
    return end.changed(**changes)


def change_degree(profile: Profile, degree: int) -> Float[np.ndarray, "2 other"]:
    """A profile cut or padded with zeros to another degree."""
    changed = np.zeros((2, degree))
    count = min(degree, profile.shape[1])
    changed[:, :count] = profile[:, :count]
    return changed


def _extrapolated(known: list[tuple[float, Profile]], place: float) -> Profile:
    if len(known) == 1:
        return known[0][1]
    (first, before), (second, here) = known
    return here + (place - second) / (second - first) * (here - before)
