"""Further roots of equations of which some are known: Newton's method with deflation.

With known roots x_k of F the deflated equations are

    G(x) = mu(x) F(x),     mu(x) = prod_k (|x - x_k|^-p + 1)

with p = 2 (Farrell, Birkisson & Funke 2015): they have the other roots of F, while near a known one
G grows without bound. Newton's step for G is that for F times a number, by the formula of Sherman
and Morrison,

    dx_G = dx_F/(1 - (grad log mu).dx_F),     dx_F = -J^-1 F,

so the derivatives of F serve. The step is cut to a largest length and halved until |G| falls by a
small part of what Newton's method promises (Armijo's rule).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic

import numpy as np
from jaxtyping import Float

from celltrain.continuation.arclength import Evaluation, NoSolution, Problem, State, Unknowns

POWER = 2.0


@dataclass(frozen=True)
class Tries:
    """How long a root is sought from one guess; lengths in the norm of the unknowns.

    `tolerance` bounds the error of a root; `decrease` is the part of the promised fall of |G| that
    a step must bring, `most_halvings` how often it is halved for that.
    """

    most_steps: int = 60
    largest: float = 0.4
    most_halvings: int = 8
    tolerance: float = 1e-9
    decrease: float = 1e-4


@dataclass(frozen=True)
class Attempt(Generic[State]):
    """Where a try has ended: at a root, or at the last point with the reason why it is none."""

    unknowns: Unknowns
    evaluation: Evaluation[State]
    steps: int
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
    unknowns, evaluation = start, problem(start, state)
    for steps in range(tries.most_steps):
        if evaluation.error < tries.tolerance:
            return Attempt(unknowns, evaluation, steps, True, "converged")
        slope = deflation(unknowns, known)[1]
        try:
            step = deflated_step(evaluation.residual, evaluation.jacobian, slope)
        except np.linalg.LinAlgError:
            return Attempt(unknowns, evaluation, steps, False, "the derivatives are singular")
        found = _shortened(problem, unknowns, evaluation, step, known, tries)
        if found is None:
            return Attempt(unknowns, evaluation, steps, False, "no step brings a root nearer")
        unknowns, evaluation = found
    converged = evaluation.error < tries.tolerance
    reason = "converged" if converged else f"{tries.most_steps} steps were not enough"
    return Attempt(unknowns, evaluation, tries.most_steps, converged, reason)


def _shortened(
    problem: Problem[State],
    unknowns: Unknowns,
    before: Evaluation[State],
    step: Unknowns,
    known: Sequence[Unknowns],
    tries: Tries,
) -> tuple[Unknowns, Evaluation[State]] | None:
    """The point that a part of a step leads to at which |G| has fallen; None if there is none."""
    length = float(np.linalg.norm(step))
    if not np.isfinite(length):
        return None
    size = deflation(unknowns, known)[0] * float(np.linalg.norm(before.residual))
    part = min(1.0, tries.largest / length)
    for _ in range(tries.most_halvings + 1):
        there = unknowns + part * step
        try:
            after = problem(there, before.state)
        except NoSolution:
            after = None
        if after is not None:
            reached = deflation(there, known)[0] * float(np.linalg.norm(after.residual))
            if reached <= (1.0 - tries.decrease * part) * size:
                return there, after
        part *= 0.5
    return None
