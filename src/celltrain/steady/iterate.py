"""Iterations towards a steady train of given parameters: the march, then Newton's method.

Implicit Euler steps with the exact Jacobian follow the train's own dynamics from the given shape,
so the branch that is found is the one that marching finds; the step doubles while the shape moves
little, until Newton's method takes over (Kelley & Keyes 1998). Newton's steps are halved until they
lower what is to vanish, by a small part of what they promise (Armijo's rule).
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from celltrain.harmonics import Profile
from celltrain.meridian.geometry import meridian_points
from celltrain.steady.base import Iteration, IterationProgress
from celltrain.steady.problem import Room, SteadyProblem, SteadyState, change_of_profile

FIRST_STEP = 0.3
# Largest displacement (r0) of a membrane point in one step.
LARGEST_MOVE = 0.4
SMALLEST_STEP = 1e-4
# Largest factor by which one step of the march may raise the residual.
LARGEST_RISE = 3.0
# Newton's method takes over when the residual is below this; if it fails the march goes on to a
# tenth of where it began.
NEWTON_RESIDUAL = 2e-2
# A step of the march, and Newton's method as a whole, leave this part at least of a film, and of a
# thick one as much as of one of this thickness, r0.
CLOSEST, WIDE = 0.4, 0.2
# Newton's step is halved at most so often, and must bring this part of the fall that it promises.
MOST_HALVINGS = 6
# Where the march may go on instead, so often.
FEW_HALVINGS = 1
DECREASE = 1e-2
# A residual that two of Newton's steps do not lower by this factor is what rounding leaves ...
STANDING = 0.5
# ... if it is below this, in U.
ROUNDING = 1e-7

Outcome = Literal["steady", "standing", "iterations", "step", "overlap", "no number"]


@dataclass(frozen=True)
class Iterated:
    """Where an iteration has ended, and why."""

    state: SteadyState
    history: tuple[Iteration, ...]
    outcome: Outcome

    @property
    def steady(self) -> bool:
        """Whether the state is steady, as far as rounding lets it be told."""
        return self.outcome in ("steady", "standing")


def march(
    problem: SteadyProblem,
    profile: Profile,
    *,
    tolerance: float,
    most: int,
    newton_failed: bool = False,
    progress: IterationProgress | None = None,
) -> Iterated:
    """From a shape to the steady train that its own dynamics reaches.

    **Arguments:** `tolerance`: bound on residual and missing volume; `most`: iterations;
    `newton_failed`: whether Newton's method was tried from this shape, and led nowhere.
    """
    history: list[Iteration] = []
    if not problem.fits(profile):
        return Iterated(problem.state(profile), (), "overlap")
    state = problem.state(profile)
    step, newton_below = FIRST_STEP, NEWTON_RESIDUAL
    if newton_failed:
        newton_below = min(newton_below, 0.1 * state.residual)
    while len(history) < most:
        if not math.isfinite(state.residual):
            return Iterated(state, tuple(history), "no number")
        if state.residual < newton_below:
            found = newton(
                problem,
                state.profile,
                tolerance=tolerance,
                most=most - len(history),
                halvings=FEW_HALVINGS,
                progress=progress,
                state=state,
            )
            if found.steady:
                return Iterated(found.state, (*history, *found.history), found.outcome)
            newton_below = 0.1 * state.residual
        change = state.step(step)
        moved = largest_move(problem, change)
        following = None
        if moved < LARGEST_MOVE:
            least = least_room(problem.room(state.profile))
            following = _after(problem, state, change, least)
        if following is None or not following.residual < LARGEST_RISE * state.residual:
            step *= 0.5
            if step < SMALLEST_STEP:
                return Iterated(state, tuple(history), "step")
            continue
        history.append(Iteration("march", state.residual, step, state.cell_velocity))
        if progress is not None:
            progress(history[-1])
        state = following
        if moved < 0.5 * LARGEST_MOVE:
            step *= 2.0
    return Iterated(state, tuple(history), "iterations")


def newton(
    problem: SteadyProblem,
    profile: Profile,
    *,
    tolerance: float,
    most: int,
    halvings: int = MOST_HALVINGS,
    progress: IterationProgress | None = None,
    state: SteadyState | None = None,
) -> Iterated:
    """Newton's method with a line search from a shape near a steady one (`state`, if known).

    The rules are those of the shape; where they change by much on the way, the end is corrected
    with its own.
    """
    history: list[Iteration] = []
    if state is None:
        if not problem.fits(profile):
            return Iterated(problem.state(profile), (), "overlap")
        state = problem.state(profile)
    least = least_room(problem.room(state.profile))
    before = math.inf
    stood = 0
    while True:
        if not math.isfinite(state.residual):
            return Iterated(state, tuple(history), "no number")
        own = problem.rules(state.profile)
        if state.error < tolerance:
            if own == state.flow.rules:
                return Iterated(state, tuple(history), "steady")
            state = problem.state(state.profile, own)
            if state.error < tolerance:
                return Iterated(state, tuple(history), "steady")
        stood = stood + 1 if state.error > STANDING * before else 0
        if stood >= 2 and state.error < ROUNDING:
            return Iterated(state, tuple(history), "standing")
        if len(history) >= most:
            return Iterated(state, tuple(history), "iterations")
        before = state.error
        following = _searched(problem, state, least, halvings)
        if following is None:
            return Iterated(state, tuple(history), "step")
        history.append(Iteration("newton", state.residual, math.inf, state.cell_velocity))
        if progress is not None:
            progress(history[-1])
        state = following


def _searched(
    problem: SteadyProblem, state: SteadyState, least: Room, halvings: int
) -> SteadyState | None:
    """The state after Newton's step, cut until it helps; None if it does not."""
    change = state.step(math.inf)
    moved = largest_move(problem, change)
    if not math.isfinite(moved):
        return None
    part = min(1.0, LARGEST_MOVE / moved) if moved > 0.0 else 1.0
    merit = _merit(state)
    for _ in range(halvings + 1):
        following = _after(problem, state, part * change, least, keep_rules=True)
        if following is not None:
            after = _merit(following)
            # Close to the end rounding may raise it.
            if after < (1.0 - DECREASE * part) * merit or following.error < ROUNDING:
                return following
        part *= 0.5
    return None


def _merit(state: SteadyState) -> float:
    """The size of what is to vanish."""
    return math.hypot(float(np.linalg.norm(state.rates)), state.missing_volume)


def _after(
    problem: SteadyProblem,
    state: SteadyState,
    change: np.ndarray,
    least: Room,
    *,
    keep_rules: bool = False,
) -> SteadyState | None:
    """The state after a change; None if it leaves less than the least room or is no number."""
    profile = problem.moved(state.profile, change)
    if (problem.room(profile) < least).any() or not problem.fits(profile):
        return None
    own = problem.rules(profile)
    if keep_rules and state.flow.rules.covers(own):
        own = state.flow.rules
    following = problem.state(profile, own)
    return following if math.isfinite(following.residual) else None


def least_room(room: Room) -> Room:
    """How close to the wall and to each other cells may come from where they are.

    Where they nearly touch a velocity is dear, and leads nowhere.
    """
    return CLOSEST * np.minimum(room, WIDE)


def largest_move(problem: SteadyProblem, change: np.ndarray) -> float:
    """Largest displacement of a membrane point by a change of the unknowns, in r0."""
    moved = float(np.hypot(*meridian_points(change_of_profile(change), 201)).max())
    return moved if math.isfinite(moved) else math.inf
