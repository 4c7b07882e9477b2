"""The ways to a steady train, tried one after another until one leads there.

From rest: the march, at a low degree, and the degree raised. Where the cell at rest has no room, or
the march leads nowhere, the same branch from a case that is easier, a wider tube with more room
between the cells: followed at the low degree, or, where that is too low for what it leads to, at
the degree itself. From another train: along a path of parameters at its own degree, or at the one
that is wanted, or from rest after all.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from celltrain.harmonics import Profile
from celltrain.meridian.geometry import size_at_rest
from celltrain.parameters import Train
from celltrain.proximity.meridian import clearance
from celltrain.steady.base import Iteration, IterationProgress
from celltrain.steady.degree import DEGREES
from celltrain.steady.iterate import ROUNDING, Iterated, march, newton
from celltrain.steady.path import Followed, change_degree, follow
from celltrain.steady.problem import SteadyProblem

#: The march from rest is of this degree at most.
MARCH_DEGREE = 12
# Distance, in r0, from wall and neighbours below which the cell at rest has no room to march.
ROOM = 0.1
# Where a detour begins: a tube and a period, relative to the cell at rest, that make it easy.
EASY_DIAMETER, EASY_PERIOD = 1.5, 2.0
# The first step of a detour, as a part of it.
FIRST_PART = 0.125


@dataclass
class Ways:
    """How many iterations are left for the ways to a train, to which tolerance (U)."""

    tolerance: float
    left: int
    progress: IterationProgress | None

    def from_rest(self, train: Train) -> tuple[Followed, str]:
        """The train that the flow reaches from rest, or where the last way has ended; and how."""
        low = train.changed(degree=min(train.degree, MARCH_DEGREE), **_no_sizes())
        rest = "march from the resting shape"
        easy = easier(train)
        detour = rest if easy is None else f"{rest} with {describe_change(easy, train)}"

        def directly() -> Followed:
            return self._raised(self._march(low), train)

        def low_detour() -> Followed:
            return self._raised(self._along(self._march(easier(low) or low), low), train)

        def detour_at_degree() -> Followed:
            begin = easy or train
            return self._along(self._raised(self._march(easier(low) or low), begin), train)

        ways: list[tuple[Callable[[], Followed], str]] = []
        if _has_room(low):
            ways.append((directly, rest))
        if easy is not None:
            ways.append((low_detour, detour))
            if low.degree != train.degree:
                ways.append((detour_at_degree, detour))
        return self._first(ways or [(directly, rest)])

    def from_train(self, begin: Train, profile: Profile, train: Train) -> tuple[Followed, str]:
        """The train that continues another one, or where the last way has ended; and how."""
        origin = f"continuation from {describe_change(begin, train)}"
        same = train
        if begin.degree != train.degree:
            same = train.changed(degree=begin.degree, **_no_sizes())

        def start() -> Followed:
            return self._begun(begin, profile)

        ways: list[tuple[Callable[[], Followed], str]] = [
            (lambda: self._raised(self._along(start(), same), train), origin)
        ]
        if begin.degree != train.degree:
            at_degree = begin.changed(degree=train.degree, **_no_sizes())
            ways.append((lambda: self._along(self._raised(start(), at_degree), train), origin))
        found, origin = self._first(ways)
        if found.complete or self.left <= 0:
            return found, origin
        again, way = self.from_rest(train)
        return _joined(found, again), way

    def _first(self, ways: list[tuple[Callable[[], Followed], str]]) -> tuple[Followed, str]:
        """The first way that leads to the train."""
        before: Followed | None = None
        origin = ""
        for way, how in ways:
            found = way()
            before = found if before is None else _joined(before, found)
            origin = how
            if before.complete or self.left <= 0:
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

    def _march(self, train: Train, profile: Profile | None = None) -> Followed:
        """From a shape, that at rest if none is given."""
        problem = SteadyProblem(train)
        found = march(
            problem,
            problem.rest if profile is None else profile,
            tolerance=self.tolerance,
            most=self.left,
            progress=self.progress,
        )
        return self._counted(Followed(problem, found, found.steady))

    def _along(self, begun: Followed, end: Train) -> Followed:
        """Along the path of parameters to another train of the same degree."""
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
            before, here = here, self._corrected(here, train)
            if not here.complete:
                # The flow leads on where Newton's method does not.
                here = _joined(here, self._march(train, _at_degree(before, here.problem)))
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


def _no_sizes() -> dict[str, None]:
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
