"""The ways to a steady train, tried one after another until one leads there.

From rest: the march, at a low degree, and the degree raised. Where the cell at rest has no room, or
the march leads nowhere, the same branch from a case that is easier, a wider tube with more room
between the cells, and, where that leads nowhere, in a flow of moderate strength, which is changed
at the end. On such a way the degree rises as the shapes ask for it: where what it leaves out of the
velocity is too much, or no step leads on. From another train: along a path of parameters in the
same manner, or at the degree that is wanted, or from rest after all.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

from celltrain.harmonics import Profile
from celltrain.harmonics.grading import regraded
from celltrain.meridian.geometry import size_at_rest
from celltrain.parameters import Train
from celltrain.proximity.meridian import clearance
from celltrain.steady.base import Iteration, IterationProgress
from celltrain.steady.degree import DEGREES
from celltrain.steady.iterate import ROUNDING, Iterated, march, newton
from celltrain.steady.path import SMALLEST_PART, Followed, change_degree, follow
from celltrain.steady.problem import SteadyProblem

#: The march from rest is of this degree at most.
MARCH_DEGREE = 12
# Distance, in r0, from wall and neighbours below which the cell at rest has no room to march.
ROOM = 0.1
# Where a detour begins: a tube and a period, relative to the cell at rest, that make it easy.
EASY_DIAMETER, EASY_PERIOD = 1.5, 2.0
# The first step of a detour, as a part of it.
FIRST_PART = 0.125
# What a degree may leave out of the velocity (U) on the way to a train of a higher one, and the
# shortest step, as a part of the way, before a higher one is tried.
ROUGH, COARSE_PART = 1e-2, 1.0 / 32.0
# How the first of rising degrees follows the cell's diameter at rest over the tube's.
FOLDING = 1.5
# The strength of a flow in which narrow tubes are easily reached, and how much stronger or weaker
# another one is before the way goes through it.
MODERATE, MODERATE_RANGE = 0.3, 2.0

#: A way to a train, and how it is called.
Way = tuple[str, Callable[[], Followed]]


@dataclass
class Ways:
    """How many iterations are left for the ways to a train, to which tolerance (U).

    `tried` is every way that was tried, with where it ended.
    """

    tolerance: float
    left: int
    progress: IterationProgress | None
    tried: list[tuple[str, Followed]] = field(default_factory=list)

    def from_rest(self, train: Train) -> tuple[Followed, str]:
        """The train that the flow reaches from rest, or where the last way has ended; and how."""
        return self._first(self._from_rest(train, march=True))

    def _from_rest(self, train: Train, *, march: bool) -> list[Way]:
        rest = "march from the resting shape"
        easy, moderate = easier(train), of_moderate_strength(train)
        ways: list[Way] = []
        if march and (easy is None or _has_room(_at_march_degree(train))):
            ways.append((rest, lambda: self._raised(self._marched(train), train)))
        if easy is not None:
            how = f"{rest} with {describe_change(easy, train)}"
            ways.append((how, lambda: self._rising(self._eased(easy, train), train)))
        if moderate is not None:
            begin = easier(moderate) or moderate
            how = f"{rest} with {describe_change(begin, train)}"
            ways.append((how, lambda: self._rising(self._eased(begin, train), moderate, train)))
        return ways

    def from_train(
        self, begin: Train, profile: Profile, train: Train, *, also_from_rest: bool
    ) -> tuple[Followed, str]:
        """The train that continues another one, or where the last way has ended; and how."""
        grading = train.resolution.grading
        profile = regraded(profile, begin.resolution.grading, grading)
        begin = begin.changed(grading=grading)
        origin = f"continuation from {describe_change(begin, train)}"

        def start() -> Followed:
            return self._begun(begin, profile)

        ways: list[Way] = [(origin, lambda: self._rising(start(), train))]
        alike = _alike(begin.changed(degree=train.degree, **no_sizes()), train)
        if begin.degree != train.degree and not alike:
            at_degree = begin.changed(degree=train.degree, **no_sizes())
            way = f"{origin}, at degree {train.degree} from the beginning"
            ways.append((way, lambda: self._along(self._raised(start(), at_degree), train)))
        if also_from_rest:
            # A march from rest whose degree is raised would come by the same train again.
            ways += self._from_rest(train, march=not alike)
        return self._first(ways)

    def _first(self, ways: Sequence[Way]) -> tuple[Followed, str]:
        """The first way that leads to the train."""
        before: Followed | None = None
        origin = ""
        for origin, way in ways:
            found = way()
            before = found if before is None else _joined(before, found)
            self.tried.append((origin, found))
            if found.complete or self.left <= 0:
                break
        assert before is not None
        return before, origin

    def _begun(self, train: Train, profile: Profile) -> Followed:
        """A train that is known; the march goes on if it was cut short before it was steady."""
        problem = SteadyProblem(train)
        state = problem.state(profile)
        if state.error < ROUNDING:
            return Followed(problem, Iterated(state, (), "steady"), True)
        return self._march(train, profile)

    def _march(
        self, train: Train, profile: Profile | None = None, *, newton_failed: bool = False
    ) -> Followed:
        """From a shape, that at rest if none is given."""
        problem = SteadyProblem(train)
        found = march(
            problem,
            problem.rest if profile is None else profile,
            tolerance=self.tolerance,
            most=self.left,
            newton_failed=newton_failed,
            progress=self.progress,
        )
        return self._counted(Followed(problem, found, found.steady))

    def _marched(self, train: Train) -> Followed:
        """From rest, at the degree of marches."""
        return self._march(_at_march_degree(train))

    def _eased(self, easy: Train, train: Train) -> Followed:
        """An easier case from rest, at the degree at which to begin the way to the other."""
        begin = min(first_degree(train), train.degree)
        return self._raised(self._marched(easy), easy.changed(degree=begin, **no_sizes()))

    def _rising(self, begun: Followed, *ends: Train) -> Followed:
        """Along paths of parameters from train to train, at a degree that rises as shapes ask."""
        here = begun
        for end in ends:
            here = self._risen(here, end)
        return here

    def _risen(self, begun: Followed, end: Train) -> Followed:
        here = begun
        while here.complete:
            degree = here.problem.degree
            highest = degree >= end.degree
            goal = end if degree == end.degree else end.changed(degree=degree, **no_sizes())
            found = self._along(here, goal, coarse=not highest)
            if found.complete:
                return self._raised(found, end)
            if highest or self.left <= 0:
                return found
            history = found.iterated.history
            if not found.iterated.steady:
                # The first step has failed.
                found = here
            reached = replace(found.iterated, history=history)
            higher = min(next(each for each in DEGREES if each > degree), end.degree)
            finer = found.problem.train.changed(degree=higher, **no_sizes())
            here = self._raised(Followed(found.problem, reached, True), finer)
        return here

    def _along(self, begun: Followed, end: Train, *, coarse: bool = False) -> Followed:
        """Along the path of parameters to another train of the same degree.

        **Arguments:** `coarse`: whether there are higher degrees for where this one does not do.
        """
        begin = begun.problem.train
        if not begun.complete:
            return begun
        if _alike(begin, end):
            if begun.iterated.state.error < self.tolerance:
                return replace(begun, problem=SteadyProblem(end))
            return self._corrected(begun, end)
        followed = follow(
            begin,
            begun.iterated.state.profile,
            end,
            tolerance=self.tolerance,
            most=self.left,
            first=FIRST_PART if begun.iterated.history else 1.0,
            smallest=COARSE_PART if coarse else SMALLEST_PART,
            rough=ROUGH if coarse else math.inf,
            progress=self.progress,
        )
        return _joined(begun, self._counted(followed))

    def _raised(self, begun: Followed, end: Train) -> Followed:
        """To another degree, at once if that leads there, otherwise through those between."""
        if not begun.complete or begun.problem.train == end:
            return begun
        found = self._corrected(begun, end)
        if found.complete:
            return found
        here = begun
        for train in _degrees_between(begun.problem.train, end):
            before = here
            at_once = before is begun and train == end
            here = found if at_once else self._corrected(here, train)
            if not here.complete:
                # The flow leads on where Newton's method does not.
                shape = _at_degree(before, here.problem)
                here = _joined(here, self._march(train, shape, newton_failed=True))
            found = _joined(found, here)
            if not here.complete:
                break
        return found

    def _corrected(self, begun: Followed, train: Train) -> Followed:
        """By Newton's method from the shape at another degree."""
        problem = SteadyProblem(train)
        found = newton(
            problem,
            _at_degree(begun, problem),
            tolerance=self.tolerance,
            most=self.left,
            progress=self.progress,
        )
        return _joined(begun, self._counted(Followed(problem, found, found.steady)))

    def _counted(self, followed: Followed) -> Followed:
        self.left -= len(followed.iterated.history)
        return followed


def easier(train: Train) -> Train | None:
    """A case in which the cell at rest has room; None if the case itself gives it that."""
    diameter, thickness = size_at_rest(SteadyProblem(train).rest)
    wide = max(train.tube.diameter, EASY_DIAMETER * diameter)
    sparse = min(train.packing, 1.0 / (EASY_PERIOD * max(thickness, 1.0)))
    if wide == train.tube.diameter and sparse == train.packing:
        return None
    return train.changed(diameter=wide, packing=sparse)


def first_degree(train: Train) -> int:
    """The degree at which to begin where the degree is left open.

    The narrower a tube is beside the resting cell the more a cell is folded in it, and the sharper
    its edges are: lower degrees have other trains in narrow tubes, or none.
    """
    diameter, _ = size_at_rest(SteadyProblem(_at_march_degree(train.changed(degree=24))).rest)
    folded = max(diameter / train.tube.diameter, 1.0) ** FOLDING
    return min((each for each in DEGREES if each >= DEGREES[0] * folded), default=DEGREES[-1])


def of_moderate_strength(train: Train) -> Train | None:
    """The case in a flow of moderate strength; None if its own is nearly that."""
    strength = train.cell.capillary_number
    if MODERATE / MODERATE_RANGE <= strength <= MODERATE * MODERATE_RANGE:
        return None
    return train.changed(capillary_number=MODERATE)


def describe_change(old: Train, new: Train) -> str:
    """The leaves in which two trains differ, with the old values: "packing = 0.2"."""
    before, after = old.leaves(), new.leaves()
    changes = [
        f"{name} = {value:.6g}" if isinstance(value, float) else f"{name} = {value}"
        for name, value in before.items()
        if after[name] != value
    ]
    return ", ".join(changes) or "the same case"


def _has_room(train: Train) -> bool:
    rest = SteadyProblem(train).rest
    return clearance(rest, train.period, train.radius) > ROOM


def _at_degree(begun: Followed, problem: SteadyProblem) -> Profile:
    """The shape of a train at another degree, displaced from rest as it is."""
    moved = begun.iterated.state.profile - begun.problem.rest
    return change_degree(moved, problem.degree) + problem.rest


def _degrees_between(begin: Train, end: Train) -> Iterator[Train]:
    for degree in DEGREES:
        if begin.degree < degree < end.degree:
            yield begin.changed(degree=degree)
    yield end


def _at_march_degree(train: Train) -> Train:
    return train.changed(degree=min(train.degree, MARCH_DEGREE), **no_sizes())


def no_sizes() -> dict[str, None]:
    """Sizes given for one degree are left out at another."""
    names = ("energy_order", "source_order", "target_order", "polar_radial", "polar_azimuthal")
    return dict.fromkeys(names)


def _alike(one: Train, other: Train) -> bool:
    """Whether two cases have the same steady train."""
    still = {"cells": 1, "viscosity_ratio": 1.0}
    return one.changed(**still).leaves() == other.changed(**still).leaves()


def _joined(first: Followed, then: Followed) -> Followed:
    """The second with the history of both."""
    if first.iterated.history == then.iterated.history[: len(first.iterated.history)]:
        return then
    history: tuple[Iteration, ...] = (*first.iterated.history, *then.iterated.history)
    return replace(then, iterated=replace(then.iterated, history=history))
