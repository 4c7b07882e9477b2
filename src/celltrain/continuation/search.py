"""A search for further steady trains of the same parameters, by deflation.

A steady train that is known is the one which the flow reaches from rest, or its branch's; others
may exist. From each of several first guesses Newton's method with all known trains deflated (see
`deflation`) looks for another, and again from the same guess when it has found one. Nothing proves
that there are no more trains: what a search says is what it tried and what it found.

Guesses are, in this order: the resting shape, the cell bent forwards and backwards (z + b cos^2
theta), the known one pointing the other way, the trains at other packings, and the known one
disturbed in its lower harmonics. A root whose meridian crosses itself or the axis is the shape of
no cell; it is deflated, too, and counted apart.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, ClassVar

import numpy as np

from celltrain.continuation.arclength import Evaluation, NoSolution, Unknowns
from celltrain.continuation.deflation import Tries, deflated_newton
from celltrain.continuation.equations import (
    SteadyPoint,
    evaluate_steady,
    known_point,
    to_unknowns,
)
from celltrain.harmonics import UNIT_DISPLACEMENT, Profile
from celltrain.parameters import CaseError
from celltrain.proximity.meridian import crosses_itself
from celltrain.quantities import Quantity, Record, quantity
from celltrain.stability import stability
from celltrain.steady import Base, NotConverged, steady
from celltrain.steady.problem import SteadyProblem, change_of_profile

#: Tries unless told otherwise: one for each guess, and some for what is found.
MOST_TRIES = 16
# Factors of the packing at which other trains are guesses.
PACKINGS = (0.7, 1.4)
# Displacements of the poles (r0) of a bent cell, and sizes of random disturbances (r0).
BENT = (0.6, -0.6, 1.2, -1.2)
DISTURBED = (0.2, 0.2, 0.5, 0.5)
# Harmonics up to this degree are disturbed.
LOWEST = 5
# Two trains nearer than this, in a/sqrt(4 pi), are the same (r0).
SAME = 1e-4


@dataclass(frozen=True, eq=False)
class SearchTry(Record):
    """One try: the guess, how it ended, and the train if it has led to one."""

    guess: Annotated[str, Quantity("", "1", "what it started from")]
    steps: Annotated[int, Quantity("", "1", "steps of Newton's method")]
    outcome: Annotated[str, Quantity("", "1", "how it ended")]
    residual: Annotated[float, Quantity("", "U", "residual at the end, NaN if there was none")]
    base: Annotated[Base | None, Quantity("", "1", "the train it led to", bulky=True)]


@dataclass(frozen=True, eq=False)
class FoundTrain(Record):
    """A further steady train, the guess that led to it, its distance from the known one in r0.

    `axisymmetric_rate` is the largest growth rate (U/r0) of its axisymmetric disturbances (m = 0,
    the waves of the train's N cells), neutral ones set aside.
    """

    base: Base
    guess: Annotated[str, Quantity("", "1", "the guess that led to it")]
    distance: Annotated[float, Quantity("", "r0", "distance from the known train")]
    axisymmetric_rate: Annotated[
        float, Quantity(r"\alpha_0", "U/r0", "largest growth rate of axisymmetric disturbances")
    ]


@dataclass(frozen=True, eq=False)
class BranchSearch(Record):
    """What was tried and what was found beside a known train."""

    kind: ClassVar[str] = "search"
    title: ClassVar[str] = "steady trains of the same parameters"

    known: Base
    tries: tuple[SearchTry, ...]
    found: tuple[FoundTrain, ...]

    @property
    def base(self) -> Base:
        """The known train."""
        return self.known

    @property
    @quantity(Quantity("", "1", "the outcome in words"))
    def statement(self) -> str:
        """The outcome in words."""
        count = len(self.tries)
        guesses = len({each.guess for each in self.tries})
        tried = f"{count} {'try' if count == 1 else 'tries'}"
        tried += f" from {guesses} {'guess' if guesses == 1 else 'guesses'}"
        if not self.found:
            return f"no further steady train was found in {tried}"
        number = len(self.found)
        trains = "train was" if number == 1 else "trains were"
        return f"{number} further steady {trains} found in {tried}"


def search_trains(
    known: Base,
    *,
    guesses: Sequence[tuple[str, Profile]] | None = None,
    most_tries: int = MOST_TRIES,
    tries: Tries | None = None,
    progress: Callable[[SearchTry], None] | None = None,
) -> BranchSearch:
    """Further steady trains of the parameters of a known one, or the statement that none was found.

    **Arguments:**

    - `known`: a steady train; its number of cells matters for the growth rates only.
    - `guesses`: names and shapes to begin from (see `harmonics.profile`), those of the module if
      not given.
    - `most_tries`: bound on the number of tries; each takes up to `tries.most_steps` steps, a step
      about a tenth of a second at degree 12.
    - `progress`: called with every try.

    **Raises:** `CaseError` for a number of tries that is not allowed.
    """
    check_tries(most_tries)
    tries = Tries() if tries is None else tries
    near = known_point(known)
    first = to_unknowns(known.profile)
    roots, done, found = [first], list[SearchTry](), list[FoundTrain]()
    for name, profile in first_guesses(known) if guesses is None else guesses:
        while len(done) < most_tries:
            start = to_unknowns(_with_volume(near.problem, profile))
            each, root = _try(name, start, near, roots, tries)
            done.append(each)
            if progress is not None:
                progress(each)
            if root is None:
                break
            roots.append(root)
            if each.base is not None:
                found.append(_describe(each.base, name, float(np.linalg.norm(root - first))))
    return BranchSearch(known, tuple(done), tuple(found))


def check_tries(most_tries: int) -> None:
    """Check that there is something to try.

    **Raises:** `CaseError` if not.
    """
    if most_tries < 1:
        raise CaseError(f"most_tries = {most_tries} is not allowed; allowed: whole numbers >= 1")


def first_guesses(known: Base) -> Iterator[tuple[str, Profile]]:
    """The guesses of the module with their names; trains at other packings as they are needed."""
    train, profile = known.train, known.profile
    rest = SteadyProblem(train).rest
    yield "the resting shape", rest
    for bend in BENT:
        bent = rest.copy()
        # z of P_20 at the pole, less that at the equator, is the bend.
        bent[0, 2] += bend / (1.5 * math.sqrt(5.0 / (4.0 * math.pi)))
        yield f"the resting shape bent by {bend:+g} r0", bent
    yield "the known one pointing the other way", reversed_profile(profile)
    for factor in PACKINGS:
        packing = factor * train.packing
        try:
            other = steady(train.changed(packing=packing), start=known, estimate_error=False)
        except (CaseError, NotConverged):
            continue
        yield f"the train at packing {packing:.3g}", other.profile
    random = np.random.default_rng(0)
    degrees = np.tile(np.arange(1, train.degree), 2)
    for number, size in enumerate(DISTURBED, 1):
        amounts = random.normal(size=len(degrees)) * (degrees <= LOWEST)
        amounts *= size * UNIT_DISPLACEMENT / np.linalg.norm(amounts)
        disturbed = profile + change_of_profile(amounts)
        yield f"the known one disturbed by {size:g} r0 (draw {number})", disturbed


def reversed_profile(profile: Profile) -> Profile:
    """The mirror image z -> -z of a shape, front pole to rear pole."""
    # P_nm(pi - theta) = (-1)^(n + m) P_nm(theta), and z changes its sign.
    return profile * (-1.0) ** (1 + np.arange(profile.shape[1]))


def steady_problem(unknowns: Unknowns, near: SteadyPoint) -> Evaluation[SteadyPoint]:
    """The steady equations of the train of a point nearby."""
    return evaluate_steady(near.problem, unknowns, near)


def _try(
    name: str, start: Unknowns, known: SteadyPoint, roots: Sequence[Unknowns], tries: Tries
) -> tuple[SearchTry, Unknowns | None]:
    """One try; the root that it found, if it is another one."""
    if min(float(np.linalg.norm(start - root)) for root in roots) < SAME:
        return SearchTry(name, 0, "the guess is a known train", math.nan, None), None
    try:
        # Forces on the wildest shapes are no numbers, which no step takes for a fall.
        with np.errstate(over="ignore", invalid="ignore"):
            attempt = deflated_newton(steady_problem, start, known, roots, tries)
    except NoSolution as failure:
        return SearchTry(name, 0, str(failure), math.nan, None), None
    error = attempt.evaluation.error
    if not attempt.converged:
        return SearchTry(name, attempt.steps, attempt.reason, error, None), None
    root, point = attempt.unknowns, attempt.evaluation.state
    if min(float(np.linalg.norm(root - each)) for each in roots) < SAME:
        return SearchTry(name, attempt.steps, "came back to a known one", error, None), None
    if crosses_itself(point.state.profile):
        return SearchTry(
            name, attempt.steps, "found a shape that crosses itself", error, None
        ), root
    base = point.base("a search by deflation")
    return SearchTry(name, attempt.steps, "found another train", error, base), root


def _describe(base: Base, guess: str, distance: float) -> FoundTrain:
    base = replace(base, origin=f"{base.origin} from {guess}")
    found = stability(base, azimuthal_numbers=[0], estimate_error=False)
    return FoundTrain(base, guess, distance, found.spectral_abscissa)


def _with_volume(problem: SteadyProblem, profile: Profile) -> Profile:
    """The shape scaled to the volume of the cell."""
    volume = problem.membrane.volume(profile)
    return profile * np.cbrt(problem.target_volume / volume) if volume > 0.0 else profile
