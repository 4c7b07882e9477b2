"""Further roots of equations of which some are known: Newton's method with deflation.

With known roots x_k of F the deflated equations are

    G(x) = mu(x) F(x),     mu(x) = prod_k (|x - x_k|^-p + 1)

with p = 2 (Farrell, Birkisson & Funke 2015): they have the other roots of F, while near a known one
G grows without bound. Newton's step for G is that for F times a number, by the formula of Sherman
and Morrison,

    dx_G = dx_F/(1 - (grad log mu).dx_F),     dx_F = -J^-1 F,

so the derivatives of F serve. The step is cut to a largest length and halved until |G| falls by a
small part of what Newton's method promises (Armijo's rule). A try from a guess that leads nowhere
would take all steps that are allowed, many of them halved often: it is given up when |G| has not
fallen to a half within some steps, and after so many evaluations of F at the latest.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic

import numpy as np
from jaxtyping import Float

from celltrain.continuation.arclength import Evaluation, NoSolution, Problem, State, Unknowns

POWER = 2.0
# What |G| must have fallen to for a try to go on.
HALF = 0.5


@dataclass(frozen=True)
class Tries:
    """How long a root is sought from one guess; lengths in the norm of the unknowns.

    `tolerance` bounds the error of a root; `decrease` is the part of the promised fall of |G| that
    a step must bring, `most_halvings` how often it is halved for that. A try is given up when |G|
    has not fallen to a half within `patience` steps, or after `most_evaluations` of F. By the flow
    (see `tries`) it is sought in `most_flow_steps`.
    """

    most_steps: int = 60
    most_evaluations: int = 120
    most_flow_steps: int = 60
    patience: int = 12
    largest: float = 0.4
    most_halvings: int = 8
    tolerance: float = 1e-9
    decrease: float = 1e-4


@dataclass(frozen=True)
class Attempt(Generic[State]):
    """Where a try has ended: at a root, or at the last point with the reason why it is none.

    `evaluations` of F are those of all steps, halved ones included.
    """

    unknowns: Unknowns
    evaluation: Evaluation[State]
    steps: int
    evaluations: int
    converged: bool
    reason: str


def deflation(
    unknowns: Unknowns, known: Sequence[Unknowns]
) -> tuple[float, Float[np.ndarray, " unknown"]]:
    """mu and grad log mu at a point that is no known root."""
    factor, slope = 1.0, np.zeros_like(unknowns)
    for root in known:
        apart = unknowns - root
        distance = float(np.linalg.norm(apart))
        factor *= distance**-POWER + 1.0
        slope -= POWER * apart / (distance**2 * (1.0 + distance**POWER))
    return factor, slope


def deflated_step(
    residual: Float[np.ndarray, " unknown"],
    jacobian: Float[np.ndarray, "unknown unknown"],
    slope: Float[np.ndarray, " unknown"],
) -> Float[np.ndarray, " unknown"]:
    """Newton's step for mu F, from F, its derivatives and `slope` = grad log mu."""
    plain = np.linalg.solve(jacobian, -residual)
    return np.asarray(plain / (1.0 - slope @ plain))


def deflated_newton(
    problem: Problem[State],
    start: Unknowns,
    state: State,
    known: Sequence[Unknowns],
    tries: Tries,
) -> Attempt[State]:
    """A root of F other than the known ones, or the point at which the search for it ended.

    **Arguments:**

    - `problem`: as many equations as unknowns; it may raise `NoSolution`, which shortens a step.
    - `start`: where to begin, not at a known root; `state`: what belongs to a point nearby.

    **Raises:** `NoSolution` if the equations cannot be evaluated at the start.
    """
    unknowns, evaluation, evaluations = start, problem(start, state), 1
    sizes = [deflated_size(start, evaluation, known)]

    def ended(reason: str) -> Attempt[State]:
        converged = evaluation.error < tries.tolerance
        why = "converged" if converged else reason
        return Attempt(unknowns, evaluation, len(sizes) - 1, evaluations, converged, why)

    while evaluation.error >= tries.tolerance or not np.isfinite(evaluation.error):
        if len(sizes) > tries.most_steps:
            return ended(f"{tries.most_steps} steps were not enough")
        if evaluations >= tries.most_evaluations:
            return ended(f"{tries.most_evaluations} evaluations were not enough")
        if len(sizes) > tries.patience and sizes[-1] > HALF * sizes[-1 - tries.patience]:
            return ended(f"given up: no nearer to a root within {tries.patience} steps")
        slope = deflation(unknowns, known)[1]
        try:
            step = deflated_step(evaluation.residual, evaluation.jacobian, slope)
        except np.linalg.LinAlgError:
            return ended("the derivatives are singular")
        found, taken = _shortened(problem, unknowns, evaluation, step, known, tries)
        evaluations += taken
        if found is None:
            return ended("no step brings a root nearer")
        unknowns, evaluation = found
        sizes.append(deflated_size(unknowns, evaluation, known))
    return ended("converged")


def deflated_size(
    unknowns: Unknowns, evaluation: Evaluation[State], known: Sequence[Unknowns]
) -> float:
    """|G| at a point that is no known root."""
    return deflation(unknowns, known)[0] * float(np.linalg.norm(evaluation.residual))


def _shortened(
    problem: Problem[State],
    unknowns: Unknowns,
    before: Evaluation[State],
    step: Unknowns,
    known: Sequence[Unknowns],
    tries: Tries,
) -> tuple[tuple[Unknowns, Evaluation[State]] | None, int]:
    """The point that a part of a step leads to at which |G| has fallen, and the evaluations of F.

    None if there is no such point.
    """
    length = float(np.linalg.norm(step))
    if not np.isfinite(length):
        return None, 0
    size = deflated_size(unknowns, before, known)
    part = min(1.0, tries.largest / length)
    for taken in range(1, tries.most_halvings + 2):
        there = unknowns + part * step
        try:
            after = problem(there, before.state)
        except NoSolution:
            after = None
        if after is not None:
            reached = deflated_size(there, after, known)
            if reached <= (1.0 - tries.decrease * part) * size:
                return (there, after), taken
        part *= 0.5
    return None, tries.most_halvings + 1
