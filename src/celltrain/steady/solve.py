"""Steady trains: from rest, from another train, or by a detour through easier ones.

The branch is the one that the flow reaches from rest (`iterate.march`). Where the cell at rest has
no room, or the march leads nowhere, the same branch is followed from a case that is easier: a wider
tube, with more room between the cells (`path.follow`).
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from celltrain.clock import timed
from celltrain.harmonics import Profile, coefficients_of
from celltrain.meridian.geometry import largest_radius, size_at_rest, streamwise_gap
from celltrain.parameters import Train
from celltrain.steady.base import Base, IterationProgress, NotConverged
from celltrain.steady.degree import DEGREES, raised
from celltrain.steady.iterate import Iterated, march, newton
from celltrain.steady.path import Followed, change_degree, follow
from celltrain.steady.problem import SteadyProblem
from celltrain.steady.room import check_room

TOLERANCE = 1e-9
MOST_ITERATIONS = 400
#: The march from rest is of this degree at most; higher degrees follow from it.
MARCH_DEGREE = 12
#: How well the cells' velocity is known, in U, where the degree is left open.
KNOWN_VELOCITY = 1e-4
# Where a detour begins: tube and period, relative to the cell at rest, in which the march is easy.
EASY_DIAMETER, EASY_PERIOD = 1.5, 2.0
# What is reported of the velocity's error over the largest difference found.
MARGIN = 1.5


def steady(
    train: Train,
    *,
    start: Base | None = None,
    tolerance: float = TOLERANCE,
    max_iterations: int = MOST_ITERATIONS,
    estimate_error: bool = True,
    progress: IterationProgress | None = None,
) -> Base:
    """The steady train that the flow reaches from rest, or from another steady train.

    **Arguments:**

    - `train`: what to compute; the number of cells does not matter here. Without a degree it gets
      the first at which the cells' velocity is known to 1e-4 U.
    - `start`: a solution at other parameters, followed to these ones. Its degree may differ.
    - `tolerance`: bound on the residual, in U. Where rounding does not let it be reached, the
      residual that stands is accepted below 1e-7 U, and reported.
    - `estimate_error`: estimate the velocity's error with finer rules (else it is not a number).
    - `progress`: called after every iteration.

    **Returns:** a `Base`.

    **Raises:** `NotConverged`, which carries the last state and the history. `CaseError` if the
    cell cannot pass the tube, or there is no room for the cells.
    """
    if train.resolution.degree is None:
        base = _at_enough_degrees(train, start, tolerance, max_iterations, progress)
        return with_velocity_error(base) if estimate_error else base
    seconds: dict[str, float] = {}
    with timed(seconds, "base"):
        check_room(train)
        search = _Search(tolerance, max_iterations, progress)
        if start is None:
            followed, origin = search.from_rest(train)
        else:
            followed = search.from_train(start, train)
            origin = f"continuation from {describe_change(start.train, train)}"
        base = describe(followed.problem, followed.iterated, origin)
    base = replace(base, seconds=seconds)
    if not followed.complete:
        raise NotConverged(_complaint(train, followed, tolerance, max_iterations), base)
    return with_velocity_error(base) if estimate_error else base


def _at_enough_degrees(
    train: Train,
    start: Base | None,
    tolerance: float,
    most: int,
    progress: IterationProgress | None,
) -> Base:
    """The train at the first degree at which its velocity is known to `KNOWN_VELOCITY`."""
    bases: list[Base] = []

    def velocity(degree: int) -> float:
        if bases:
            bases.append(at_degree(bases[-1], degree, progress=progress))
        else:
            bases.append(
                steady(
                    train.changed(degree=degree),
                    start=start,
                    tolerance=tolerance,
                    max_iterations=most,
                    estimate_error=False,
                    progress=progress,
                )
            )
        return bases[-1].cell_velocity

    raised(velocity, lambda found: found.left <= KNOWN_VELOCITY)
    return bases[-1]


@dataclass
class _Search:
    """The ways to a train, and how many iterations they have left."""

    tolerance: float
    left: int
    progress: IterationProgress | None

    def _counted(self, followed: Followed) -> Followed:
        self.left -= len(followed.iterated.history)
        return followed

    def from_rest(self, train: Train) -> tuple[Followed, str]:
        """By the march, or a detour; then to the degree."""
        low = train.changed(degree=min(train.degree, MARCH_DEGREE), **_no_sizes(train))
        origin = "march from the resting shape"
        marched = self._march(low)
        if not marched.complete:
            easy = easier(low)
            if easy is not None:
                begun = self._march(easy)
                if begun.complete:
                    origin = f"march from the resting shape with {describe_change(easy, low)}"
                    profile = begun.iterated.state.profile
                    marched = self._follow(easy, profile, low, first=0.125)
                    marched = _joined(begun, marched)
        if not marched.complete or low == train:
            return marched, origin
        return _joined(marched, self._to_degree(low, marched.iterated.state.profile, train)), origin

    def from_train(self, start: Base, train: Train) -> Followed:
        """Along a path of parameters at the start's degree, then to another degree."""
        same = train.changed(degree=start.train.degree, **_no_sizes(train))
        if start.train.degree == train.degree:
            same = train
        profile = start.profile
        if same == train or not _alike(start.train, same):
            followed = self._follow(start.train, profile, same)
            if not followed.complete or same == train:
                return followed
            profile = followed.iterated.state.profile
        return self._to_degree(same, profile, train)

    def _march(self, train: Train) -> Followed:
        problem = SteadyProblem(train)
        found = march(
            problem, problem.rest, tolerance=self.tolerance, most=self.left, progress=self.progress
        )
        return self._counted(Followed(problem, found, found.steady))

    def _follow(self, begin: Train, profile: Profile, end: Train, first: float = 1.0) -> Followed:
        return self._counted(
            follow(
                begin,
                profile,
                end,
                tolerance=self.tolerance,
                most=self.left,
                first=first,
                progress=self.progress,
            )
        )

    def _to_degree(self, train: Train, profile: Profile, end: Train) -> Followed:
        """At once if that leads there, otherwise through the degrees between."""
        followed = self._corrected(end, profile, train)
        if followed.complete:
            return followed
        here, step = profile, train
        for degree in [d for d in DEGREES if train.degree < d < end.degree] + [end.degree]:
            following = end if degree == end.degree else train.changed(degree=degree)
            followed = _joined(followed, self._corrected(following, here, step))
            if not followed.complete:
                break
            here, step = followed.iterated.state.profile, following
        return followed

    def _corrected(self, train: Train, profile: Profile, before: Train) -> Followed:
        problem = SteadyProblem(train)
        moved = problem.rest - change_degree(SteadyProblem(before).rest, problem.degree)
        guess = change_degree(profile, problem.degree) + moved
        found = newton(
            problem, guess, tolerance=self.tolerance, most=self.left, progress=self.progress
        )
        return self._counted(Followed(problem, found, found.steady))


def _no_sizes(train: Train) -> dict[str, None]:
    """Sizes given for one degree are left out at another."""
    names = ("energy_order", "source_order", "target_order", "polar_radial", "polar_azimuthal")
    return dict.fromkeys(names)


def _alike(one: Train, other: Train) -> bool:
    """Whether two cases have the same steady train."""
    still = {"cells": 1, "viscosity_ratio": 1.0}
    return one.changed(**still).leaves() == other.changed(**still).leaves()


def _joined(first: Followed, then: Followed) -> Followed:
    history = (*first.iterated.history, *then.iterated.history)
    return replace(then, iterated=replace(then.iterated, history=history))


def easier(train: Train) -> Train | None:
    """A case in which the cell at rest has room; None if the case itself gives it that."""
    diameter, thickness = size_at_rest(SteadyProblem(train).rest)
    wide = max(train.tube.diameter, EASY_DIAMETER * diameter)
    sparse = min(train.packing, 1.0 / (EASY_PERIOD * max(thickness, 1.0)))
    if wide == train.tube.diameter and sparse == train.packing:
        return None
    return train.changed(diameter=wide, packing=sparse)


def with_velocity_error(base: Base) -> Base:
    """The same train with an estimate of what grids and rules leave of the cells' velocity.

    The largest difference from the rates of change with finer rules, relative to the largest rate
    and times a margin.
    """
    seconds = dict(base.seconds)
    with timed(seconds, "velocity_error"):
        flow = SteadyProblem(base.train).flow(base.profile)
        finer = SteadyProblem(base.train, finer=True).flow(base.profile)
        change = np.linalg.norm(finer.at_targets(flow.rates - finer.rates), axis=1).max()
        largest = np.linalg.norm(finer.at_targets(finer.rates), axis=1).max()
    return replace(base, velocity_error=MARGIN * float(change / largest), seconds=seconds)


def with_finer_rules(base: Base) -> Base:
    """The same train at the same degree with finer rules (of which the result knows nothing).

    **Raises:** `NotConverged` if it is not found.
    """
    problem = SteadyProblem(base.train, finer=True)
    found = newton(problem, base.profile, tolerance=TOLERANCE, most=MOST_ITERATIONS)
    described = describe(problem, found, base.origin)
    if not found.steady:
        raise NotConverged("no steady train with finer rules", described)
    return described


def at_degree(base: Base, degree: int, *, progress: IterationProgress | None = None) -> Base:
    """The same train at another degree, without an estimate of the velocity's error.

    **Raises:** `NotConverged` if it is not found, `CaseError` if the case does not allow it.
    """
    train = base.train.changed(degree=degree)
    found = steady(train, start=base, estimate_error=False, progress=progress)
    return replace(found, history=base.history + found.history, origin=base.origin)


def describe(problem: SteadyProblem, iterated: Iterated, origin: str) -> Base:
    """What is reported of a state."""
    state, train = iterated.state, problem.train
    profile = state.profile.copy()
    profile[0, 0] = 0.0
    return Base(
        train=train,
        coefficients=coefficients_of(profile),
        cell_velocity=state.cell_velocity,
        gap=streamwise_gap(profile, train.period),
        largest_radius=largest_radius(profile),
        effective_viscosity=state.flow.effective_viscosity,
        residual=state.residual,
        truncation_error=state.truncation_error,
        velocity_error=math.nan,
        history=iterated.history,
        origin=origin,
        seconds={},
    )


def _complaint(train: Train, followed: Followed, tolerance: float, most: int) -> str:
    iterated = followed.iterated
    reason = {
        "iterations": f"{most} iterations were not enough",
        "step": "no shorter step leads on",
        "overlap": "the cells overlap each other or the wall",
        "no number": "the residual is not a number",
    }.get(iterated.outcome, "a way through other parameters ended")
    where = describe_change(followed.problem.train, train)
    reached = "" if followed.problem.train == train else f"; reached on the way: {where}"
    return (
        f"no steady train: {reason} (iteration {len(iterated.history)}, residual"
        f" {iterated.state.residual:.2e} U, wanted {tolerance:.0e} U){reached}"
    )


def describe_change(old: Train, new: Train) -> str:
    """The leaves in which two trains differ, with the old values: "packing = 0.2"."""
    before, after = old.leaves(), new.leaves()
    changes = [
        f"{name} = {value:.6g}" if isinstance(value, float) else f"{name} = {value}"
        for name, value in before.items()
        if after[name] != value
    ]
    return ", ".join(changes) or "the same case"
