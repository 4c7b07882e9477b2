"""Curves of solutions of n equations in n + 1 unknowns, by pseudo-arclength continuation.

From a point x with the unit tangent t the next one is sought at x + h t and corrected by Newton's
method across the tangent (Keller 1977),

    [ J   ] [ dx ] = - [ F(x)          ]
    [ t^T ] [    ]     [ t.(x - x - h t) ],

so that folds, where one of the unknowns turns back, are passed like any other point. The new
tangent is the null vector of J there. The step h grows while few corrections are needed, and is
halved where they fail or the curve bends by much.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Annotated, Generic, Literal, TypeVar

import numpy as np
from jaxtyping import Float

from celltrain.quantities import Quantity

State = TypeVar("State")
Unknowns = Float[np.ndarray, " unknown"]


class NoSolution(Exception):
    """The equations cannot be evaluated at these unknowns."""


class CurveLost(RuntimeError):
    """No further point was found with the smallest step."""


@dataclass(frozen=True)
class CurveEnding:
    """Why there are no more points of a curve."""

    kind: Annotated[
        Literal["reached", "turned back", "enough", "lost", "interrupted"],
        Quantity("", "1", "why there are no more points"),
    ]
    message: Annotated[str, Quantity("", "1", "the same in words")]


@dataclass(frozen=True)
class Evaluation(Generic[State]):
    """The equations at some unknowns: F, its derivatives, how far off it is, what belongs to it."""

    residual: Float[np.ndarray, " equation"]
    jacobian: Float[np.ndarray, "equation unknown"]
    error: float
    state: State


@dataclass(frozen=True)
class Steps:
    """How a curve is followed; lengths in the norm of the unknowns.

    `tolerance` bounds the error of a point; `turn` is the smallest cosine of the angle between the
    tangents of two points in a row.
    """

    first: float = 0.05
    smallest: float = 1e-4
    largest: float = 0.2
    tolerance: float = 1e-9
    most_corrections: int = 7
    turn: float = 0.8


@dataclass(frozen=True)
class CurvePoint(Generic[State]):
    """A point of a curve, with its unit tangent and the step and corrections that led to it."""

    unknowns: Unknowns
    tangent: Unknowns
    state: State
    step: float
    corrections: int


# The equations at some unknowns, given what belongs to a point nearby.
Problem = Callable[[Unknowns, State], Evaluation[State]]

# Corrections up to this number let the step grow.
FEW_CORRECTIONS = 3
GROWTH = 1.5


def trace_curve(
    problem: Problem[State],
    start: Unknowns,
    direction: Unknowns,
    state: State,
    steps: Steps,
) -> Iterator[CurvePoint[State]]:
    """The points of the curve through, or near to, a first guess, one by one and without end.

    **Arguments:**

    - `problem`: the equations; it may raise `NoSolution`.
    - `start`: unknowns near a solution, which is found first.
    - `direction`: the curve is followed to that side.
    - `state`: what belongs to the start.

    **Raises:** `CurveLost` when there is no solution near the start, or no way on.
    """
    found = _corrected(problem, start, None, state, steps)
    if found is None:
        raise CurveLost("there is no solution near the start")
    unknowns, evaluation, corrections = found
    tangent = _tangent(evaluation.jacobian, direction)
    yield CurvePoint(unknowns, tangent, evaluation.state, 0.0, corrections)
    step = steps.first
    while True:
        if step < steps.smallest:
            raise CurveLost(f"the step became shorter than {steps.smallest:g}")
        found = _corrected(problem, unknowns + step * tangent, tangent, evaluation.state, steps)
        following = None if found is None else _tangent(found[1].jacobian, tangent)
        if found is None or following is None or following @ tangent < steps.turn:
            step *= 0.5
            continue
        unknowns, evaluation, corrections = found
        tangent = following
        yield CurvePoint(unknowns, tangent, evaluation.state, step, corrections)
        if corrections <= FEW_CORRECTIONS:
            step = min(GROWTH * step, steps.largest)


def _corrected(
    problem: Problem[State],
    guess: Unknowns,
    tangent: Unknowns | None,
    state: State,
    steps: Steps,
) -> tuple[Unknowns, Evaluation[State], int] | None:
    """The solution across the tangent from a guess, or the nearest one; None if it is not found."""
    unknowns = guess
    before = np.inf
    for corrections in range(steps.most_corrections + 1):
        try:
            evaluation = problem(unknowns, state)
        except NoSolution:
            return None
        if evaluation.error < steps.tolerance:
            return unknowns, evaluation, corrections
        # Newton's method, once close, does not go away again.
        if not np.isfinite(evaluation.error) or evaluation.error > 2.0 * before:
            return None
        before = evaluation.error
        state = evaluation.state
        unknowns = unknowns + _correction(evaluation, unknowns - guess, tangent, steps.largest)
    return None


def _correction(
    evaluation: Evaluation[State], moved: Unknowns, tangent: Unknowns | None, largest: float
) -> Unknowns:
    """Newton's step across the tangent; without one, the shortest, cut to the largest step."""
    if tangent is None:
        shortest = np.linalg.lstsq(evaluation.jacobian, -evaluation.residual, rcond=None)[0]
        length = float(np.linalg.norm(shortest))
        return np.asarray(shortest * (largest / length if length > largest else 1.0))
    matrix = np.vstack([evaluation.jacobian, tangent])
    return np.linalg.solve(matrix, -np.append(evaluation.residual, tangent @ moved))


def _tangent(jacobian: Float[np.ndarray, "equation unknown"], direction: Unknowns) -> Unknowns:
    """The unit null vector of J on the side of a direction."""
    null = np.linalg.svd(jacobian)[2][-1]
    return np.asarray(null if null @ direction >= 0.0 else -null)
