"""Further steady trains of one case, by Newton's method with the known ones taken out.

With F the steady equations and a_k what is known, roots of

    G(a) = M(a) F(a),   M(a) = prod_k (1/|a - a_k|^2 + 1)

are those of F but a_k (Farrell, Birkisson & Funke 2015). Newton's step d of F is that of G when it
is divided by 1 - (grad M . d)/M, so nothing but d is computed. A search from a few shapes that
finds nothing proves nothing: what was tried is part of the result.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from celltrain.parameters import CaseError
from celltrain.steady import Base
from celltrain.steady.solve import comes_close, describe
from celltrain.steady.system import SteadySystem, bordered_step, steady_system
from celltrain.train import largest_radius, streamwise_gap

Unknowns = Float[np.ndarray, " unknown"]
#: Newton's step of the plain equations at a point, and their residual there; None if the point is
#: not allowed.
Equations = Callable[[Unknowns], tuple[Unknowns, float] | None]

MOST_ITERATIONS = 60
# Residual (U) of what is found, and the distance (r0) within which two trains are one.
TOLERANCE = 1e-8
SAME = 1e-3
# Longest step, in units of the unknowns.
LONGEST_STEP = 0.2
# Least distance from the wall, over that of the resting or the known cell: nearer to it the wall is
# not resolved, and what is found there means nothing.
WALL_SHARE = 0.5
# A displacement by one r0 in the coefficients.
UNIT = math.sqrt(4.0 * math.pi)


@dataclass(frozen=True)
class Attempt:
    """One start of a search, and how it ended."""

    start: str
    ending: str
    iterations: int


@dataclass(frozen=True)
class Search:
    """What a search for further steady trains found.

    Attributes:
        known: the train that was known.
        found: others, in the order in which they were found.
        attempts: all starts, in order.
    """

    known: Base
    found: tuple[Base, ...]
    attempts: tuple[Attempt, ...]

    def __str__(self) -> str:
        count = f"{len(self.attempts)} starts"
        if not self.found:
            return f"no further steady train found from {count}"
        velocities = ", ".join(f"U_c = {base.cell_velocity:.4f} U" for base in self.found)
        return f"{len(self.found)} found from {count}: {velocities}"


def deflated_step(step: Unknowns, point: Unknowns, known: Sequence[Unknowns]) -> Unknowns:
    """Newton's step of M F from that of F."""
    # grad log(1/r^2 + 1) = -2 (a - a_k)/(r^2 (1 + r^2)).
    slope = 0.0
    for root in known:
        away = point - root
        square = float(away @ away)
        slope -= 2.0 * float(away @ step) / (square * (1.0 + square))
    return step / (1.0 - slope)


def deflated_newton(
    equations: Equations,
    start: Unknowns,
    known: Sequence[Unknowns],
    *,
    tolerance: float,
    most_iterations: int = MOST_ITERATIONS,
    longest_step: float = math.inf,
) -> tuple[Unknowns | None, str, int]:
    """A root other than the known ones, or None; how it ended, and the number of steps.

    **Arguments:** `tolerance`: of the residual; `longest_step`: longer ones are shortened to it.
    """
    point = np.array(start)
    for iteration in range(most_iterations + 1):
        found = equations(point)
        if found is None:
            return None, "left what is allowed", iteration
        step, residual = found
        if residual < tolerance:
            return point, "found", iteration
        if not np.isfinite(step).all():
            return None, "no finite step", iteration
        step = deflated_step(step, point, known)
        point = point + step * min(1.0, longest_step / float(np.linalg.norm(step)))
    return None, "did not converge", most_iterations


def further_trains(
    base: Base,
    *,
    random_starts: int = 4,
    size: float = 0.3,
    seed: int = 0,
    most_iterations: int = MOST_ITERATIONS,
    progress: Callable[[Attempt], None] | None = None,
) -> Search:
    """Other axisymmetric steady trains of the same case, searched for from several shapes.

    These are the resting cell, the known train's cell and the resting cell turned to face the other
    way, and the known cell disturbed at random.

    **Arguments:** `random_starts`, `size` (r0, of their displacements, falling with the degree),
    `seed`; `most_iterations`: of each attempt; `progress`: called after every attempt.

    **Raises:** `CaseError` for a negative number of starts or a size that is not positive.
    """
    if random_starts < 0 or not size > 0.0:
        raise CaseError(
            f"random_starts = {random_starts}, size = {size:g} are not allowed; allowed: >= 0, > 0"
        )
    train = base.train
    # The closest pairs have rules of their own, which far ones do not need but do not mind.
    system = steady_system(train, close=comes_close(train, base.coefficients))
    rest = np.asarray(system.operator.membrane.reference_shape)
    room = train.radius - max(largest_radius(rest), largest_radius(base.coefficients))
    volume = float(system.operator.membrane.volume(jnp.asarray(rest)))

    def equations(point: Unknowns) -> tuple[Unknowns, float] | None:
        unknowns = UNIT * point
        shape = np.asarray(system.shape(jnp.asarray(unknowns)))
        if not np.isfinite(shape).all() or streamwise_gap(shape, train.period) <= 0.0:
            return None
        if train.radius - largest_radius(shape) < WALL_SHARE * room:
            return None
        state = system.state(jnp.asarray(unknowns))
        step = bordered_step(state, volume, math.inf) / UNIT
        return step, float(state.residual) + abs(float(state.volume) - volume)

    roots = [_point(system, base.coefficients)]
    found: list[Base] = []
    attempts: list[Attempt] = []
    for name, shape in _starts(system, base, rest, random_starts, size, seed):
        point, ending, iterations = deflated_newton(
            equations,
            _point(system, shape),
            roots,
            tolerance=TOLERANCE,
            most_iterations=most_iterations,
            longest_step=LONGEST_STEP,
        )
        if point is not None and min(np.linalg.norm(point - root) for root in roots) < SAME:
            point, ending = None, "came back to a known one"
        attempts.append(Attempt(name, ending, iterations))
        if point is not None:
            roots.append(point)
            state = system.state(jnp.asarray(UNIT * point))
            origin = f"deflation of {len(roots) - 1} known, from {name}"
            found.append(describe(system, train, UNIT * point, state, (), origin))
        if progress is not None:
            progress(attempts[-1])
    return Search(base, tuple(found), tuple(attempts))


def _point(system: SteadySystem, shape: Float[np.ndarray, "3 coefficient"]) -> Unknowns:
    return np.asarray(system.unknowns(jnp.asarray(shape))) / UNIT


def _starts(
    system: SteadySystem,
    base: Base,
    rest: Float[np.ndarray, "3 coefficient"],
    random_starts: int,
    size: float,
    seed: int,
) -> list[tuple[str, Float[np.ndarray, "3 coefficient"]]]:
    """Shapes to start from, by name."""
    known = base.coefficients
    n = np.floor(np.sqrt(np.arange(known.shape[-1]))).astype(int)
    order = np.arange(known.shape[-1]) - n * n - n
    # z -> -z, and theta -> pi - theta, so that the normal stays outward.
    flip = np.array([1.0, 1.0, -1.0])[:, None] * (-1.0) ** (n + order)
    starts = [
        ("the resting cell", rest),
        ("the known cell, turned", flip * known),
        ("the resting cell, pressed flat", rest * np.array([1.1, 1.1, 0.8])[:, None]),
        ("the resting cell, drawn out", rest * np.array([0.8, 0.8, 1.5])[:, None]),
    ]
    random = np.random.default_rng(seed)
    for number in range(random_starts):
        noise = random.normal(size=len(np.asarray(system.basis)))
        moved = np.einsum("u,uik->ik", noise, np.asarray(system.basis)) / (1.0 + n) ** 2
        moved *= UNIT * size / np.linalg.norm(moved)
        starts.append((f"the known cell, disturbed ({number + 1})", known + moved))
    return starts
