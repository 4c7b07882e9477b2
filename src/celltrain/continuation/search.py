"""A search for further steady trains of the same parameters.

A steady train that is known is the one which the flow reaches from rest, or its branch's; others
may exist. From each of several first guesses (see `guesses`) the flow leads to one, and Newton's
method with all known trains deflated looks for another (see `tries`), again from the same guess
when it has found one. Nothing proves that there are no more trains: what a search says is what it
tried and what it found.

It is made at a low degree, and what it finds is followed to a higher one, as low degrees have
trains of their own: what is none there is counted apart. So is a root whose meridian crosses
itself or the axis, the shape of no cell; both are deflated, too.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, ClassVar

import numpy as np

from celltrain.continuation.arclength import Unknowns
from celltrain.continuation.deflation import Tries
from celltrain.continuation.equations import known_point, to_unknowns
from celltrain.continuation.guesses import first_guesses
from celltrain.continuation.tries import CROSSED, SearchTry, by_deflation, by_flow
from celltrain.harmonics import Profile
from celltrain.parameters import CaseError, Train
from celltrain.proximity.meridian import crosses_itself
from celltrain.quantities import Quantity, Record, quantity
from celltrain.stability import stability
from celltrain.steady import Base, NotConverged
from celltrain.steady.degree import DEGREES
from celltrain.steady.iterate import Iterated, newton
from celltrain.steady.path import change_degree
from celltrain.steady.problem import SteadyProblem
from celltrain.steady.solve import TOLERANCE, at_degree, describe
from celltrain.steady.ways import first_degree, no_sizes

#: Tries unless told otherwise: two for each guess, and some for what is found.
MOST_TRIES = 48
# Degrees of the search up to the first, and the least ratio of the one that trains are followed to.
HIGHEST, FINER = 48, 1.5
# Newton's steps at each degree on the way there.
MOST_CORRECTIONS = 20
# How a try is called that led to what is no train at the higher degree.
ALONE = "found a train of degree"


@dataclass(frozen=True, eq=False)
class FoundTrain(Record):
    """A further steady train at the higher degree, and the guess that led to it.

    `axisymmetric_rate` is the largest growth rate (U/r0) of its axisymmetric disturbances (m = 0,
    the waves of the train's N cells), neutral ones set aside.
    """

    base: Base
    guess: Annotated[str, Quantity("", "1", "the guess that led to it")]
    distance: Annotated[
        float, Quantity("", "r0", "distance from the known train at the degree of the search")
    ]
    velocity_change: Annotated[
        float, Quantity("", "U", "change of its velocity from the degree of the search")
    ]
    axisymmetric_rate: Annotated[
        float, Quantity(r"\alpha_0", "U/r0", "largest growth rate of axisymmetric disturbances")
    ]


@dataclass(frozen=True, eq=False)
class BranchSearch(Record):
    """What was tried and what was found beside a known train."""

    kind: ClassVar[str] = "search"
    title: ClassVar[str] = "steady trains of the same parameters"

    known: Base
    degree: Annotated[int, Quantity("", "1", "degree of the search")]
    higher_degree: Annotated[int, Quantity("", "1", "degree at which a found train is one, too")]
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
        count, alone = len(self.tries), self.alone
        guesses = len({each.guess for each in self.tries})
        tried = f"{count} {'try' if count == 1 else 'tries'}"
        tried += f" from {guesses} {'guess' if guesses == 1 else 'guesses'}"
        tried += f" at degree {self.degree}"
        if alone:
            tried += f"; {alone} more {'is' if alone == 1 else 'are'} of this degree alone"
        if not self.found:
            return f"no further steady train was found in {tried}"
        number = len(self.found)
        trains = "train was" if number == 1 else "trains were"
        return f"{number} further steady {trains} found in {tried}"

    @property
    @quantity(Quantity("", "1", "roots that are no train at the higher degree"))
    def alone(self) -> int:
        """How many roots belong to the degree of the search alone."""
        return sum(each.outcome.startswith(ALONE) for each in self.tries)

    @property
    @quantity(Quantity("", "1", "roots that are the shape of no cell"))
    def crossed(self) -> int:
        """How many roots have a meridian that crosses itself."""
        return sum(each.outcome == CROSSED for each in self.tries)


def search_trains(
    known: Base,
    *,
    guesses: Sequence[tuple[str, Profile]] | None = None,
    degree: int | None = None,
    most_tries: int = MOST_TRIES,
    tries: Tries | None = None,
    progress: Callable[[SearchTry], None] | None = None,
) -> BranchSearch:
    """Further steady trains of the parameters of a known one, or the statement that none was found.

    **Arguments:**

    - `known`: a steady train; its number of cells matters for the growth rates only.
    - `guesses`: names and shapes to begin from (see `harmonics.profile`), of the degree of the
      search; those of `guesses` if not given.
    - `degree`: of the search; unless given the first that serves in such a tube, or the known
      train's if that is lower. What is found is followed to the known train's degree if that is
      higher, and to one half as high again if not.
    - `most_tries`: bound on the number of tries; each by deflation takes up to
      `tries.most_evaluations`, a fiftieth of a second each at degree 12 and up to sixteen times
      that.
    - `progress`: called with every try.

    **Raises:** `CaseError` for a number of tries or a degree that is not allowed.
    """
    check_tries(most_tries)
    tries = Tries() if tries is None else tries
    low = _at_search_degree(known, degree)
    end = _finer(low.train, known.train)
    near = known_point(low)
    first = to_unknowns(low.profile)
    roots, done, found = [first], list[SearchTry](), list[FoundTrain]()
    for name, guess in first_guesses(low) if guesses is None else guesses:
        profile, way = _with_volume(near.problem, guess), by_flow
        while len(done) < most_tries:
            each, root = way(name, profile, near, roots, tries)
            base = each.base
            if root is not None:
                roots.append(root)
            if root is not None and base is not None:
                there = _followed(base, end, roots)
                if there is None:
                    each = replace(each, base=None, outcome=f"{ALONE} {low.train.degree} alone")
                else:
                    distance = float(np.linalg.norm(root - first))
                    found.append(_describe(base, there, name, distance))
                    each = replace(each, base=there)
            done.append(each)
            if progress is not None:
                progress(each)
            if root is None and way is by_deflation:
                break
            way = by_deflation
        if len(done) >= most_tries:
            break
    return BranchSearch(known, low.train.degree, end.degree, tuple(done), tuple(found))


def check_tries(most_tries: int) -> None:
    """Check that there is something to try.

    **Raises:** `CaseError` if not.
    """
    if most_tries < 1:
        raise CaseError(f"most_tries = {most_tries} is not allowed; allowed: whole numbers >= 1")


def _at_search_degree(known: Base, degree: int | None) -> Base:
    """The known train at the degree of the search.

    **Raises:** `CaseError` for a degree that is not allowed, or at which the train is not found.
    """
    own = known.train.degree
    low = min(own, HIGHEST, first_degree(known.train)) if degree is None else degree
    if low >= DEGREES[-1]:
        raise CaseError(f"degree = {low} is not allowed; allowed: < {DEGREES[-1]}")
    if low == own:
        return known
    try:
        return at_degree(known, low)
    except NotConverged as failure:
        if degree is None and own < DEGREES[-1]:
            return known
        raise CaseError(f"degree = {low} is not allowed: {failure}") from None


def _finer(train: Train, known: Train) -> Train:
    """The case at the degree to which what is found is followed."""
    if known.degree > train.degree:
        return known
    return _of_degree(
        known, next((each for each in DEGREES if each >= FINER * train.degree), DEGREES[-1])
    )


def _followed(base: Base, end: Train, roots: Sequence[Unknowns]) -> Base | None:
    """The train at a higher degree; None if there is none, or if it is nearer to another root.

    By Newton's method through the degrees between: the flow would leave an unstable train.
    """
    lowest, low = SteadyProblem(base.train), base.train.degree
    problem, moved = lowest, base.profile - lowest.rest
    found: Iterated | None = None
    between = (each for each in DEGREES if low < each < end.degree)
    for train in (*(_of_degree(end, each) for each in between), end):
        problem = SteadyProblem(train)
        guess = change_degree(moved, train.degree) + problem.rest
        found = newton(problem, guess, tolerance=TOLERANCE, most=MOST_CORRECTIONS)
        if not found.steady:
            return None
        moved = found.state.profile - problem.rest
    back = to_unknowns(change_degree(moved, low) + lowest.rest)
    apart = [float(np.linalg.norm(back - root)) for root in roots]
    if found is None or int(np.argmin(apart)) != len(roots) - 1:
        return None
    there = describe(problem, found, base.origin)
    return None if crosses_itself(there.profile) else there


def _of_degree(train: Train, degree: int) -> Train:
    """The same case at another degree, with the sizes of that."""
    return train.changed(degree=degree, **no_sizes())


def _describe(base: Base, there: Base, guess: str, distance: float) -> FoundTrain:
    rates = stability(there, azimuthal_numbers=[0], estimate_error=False)
    change = abs(there.cell_velocity - base.cell_velocity)
    return FoundTrain(there, guess, distance, change, rates.spectral_abscissa)


def _with_volume(problem: SteadyProblem, profile: Profile) -> Profile:
    """The shape scaled to the volume of the cell."""
    volume = problem.membrane.volume(profile)
    return profile * np.cbrt(problem.target_volume / volume) if volume > 0.0 else profile
