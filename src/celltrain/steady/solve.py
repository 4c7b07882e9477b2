"""Steady trains: from rest, from another train, or by a detour through easier ones.

The branch is the one that the flow reaches from rest; `ways` has the ways to it.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from celltrain.clock import timed
from celltrain.harmonics import coefficients_of, profile_of
from celltrain.meridian.geometry import largest_radius
from celltrain.parameters import Train
from celltrain.proximity.meridian import crosses_itself, streamwise_gap
from celltrain.steady.base import Base, IterationProgress, MembraneCrosses, NotConverged
from celltrain.steady.degree import raised
from celltrain.steady.iterate import Iterated, newton
from celltrain.steady.path import Followed
from celltrain.steady.problem import SteadyProblem
from celltrain.steady.room import check_room
from celltrain.steady.ways import Ways, describe_change, first_degree

TOLERANCE = 1e-9
MOST_ITERATIONS = 400
#: How well the cells' velocity is known, in U, where the degree is left open.
KNOWN_VELOCITY = 1e-4
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
    - `estimate_error`: estimate the velocity's error with finer rules (else it is NaN).
    - `progress`: called after every iteration.

    **Returns:** a `Base`.

    **Raises:** `NotConverged`, which carries the last state and the history. `CaseError` if the
    cell cannot pass the tube, or there is no room for the cells.
    """
    if train.resolution.degree is None:
        base = _at_enough_degrees(train, start, tolerance, max_iterations, progress)
    else:
        ways = Ways(tolerance, max_iterations, progress)
        base = _found(train, start, ways, also_from_rest=True)
    return with_velocity_error(base) if estimate_error else base


def _found(train: Train, start: Base | None, ways: Ways, *, also_from_rest: bool) -> Base:
    """The train at its degree; `also_from_rest`: where no way leads there from `start`."""
    seconds: dict[str, float] = {}
    most = ways.left
    with timed(seconds, "base"):
        check_room(train)
        if start is None:
            followed, origin = ways.from_rest(train)
        else:
            followed, origin = ways.from_train(
                start.train, start.profile, train, also_from_rest=also_from_rest
            )
        base = describe(followed.problem, followed.iterated, origin)
    base = replace(base, seconds=seconds)
    if not followed.complete:
        raise NotConverged(_complaint(train, ways.tried, ways.tolerance, most), base)
    if crosses_itself(base.profile):
        raise MembraneCrosses(
            "no steady train of cells: the membrane of the one that was found crosses itself, as in"
            " flow too fast for the tube or the membrane",
            base,
        )
    return base


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

    raised(velocity, lambda found: found.left <= KNOWN_VELOCITY, first=first_degree(train))
    return bases[-1]


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

    One that is found from rest might be another train, and is not looked for.

    **Raises:** `NotConverged` if it is not found, `CaseError` if the case does not allow it.
    """
    train = base.train.changed(degree=degree)
    ways = Ways(TOLERANCE, MOST_ITERATIONS, progress)
    found = _found(train, base, ways, also_from_rest=False)
    return replace(found, history=base.history + found.history, origin=base.origin)


def describe(problem: SteadyProblem, iterated: Iterated, origin: str) -> Base:
    """What is reported of a state."""
    state, train = iterated.state, problem.train
    profile = state.profile.copy()
    profile[0, 0] = 0.0
    coefficients = coefficients_of(profile)
    # As the result will give it again, to the last bit.
    profile = profile_of(coefficients)
    return Base(
        train=train,
        coefficients=coefficients,
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


def _complaint(
    train: Train, tried: Sequence[tuple[str, Followed]], tolerance: float, most: int
) -> str:
    """Why there is no train, and what was tried."""
    _, last = tried[-1]
    iterations = max(len(found.iterated.history) for _, found in tried)
    reasons = {
        "iterations": f"{most} iterations were not enough",
        "step": "no shorter step leads on",
        "overlap": "the cells overlap each other or the wall",
        "no number": "the residual is NaN",
    }
    reason = reasons.get(last.iterated.outcome, "a way through other parameters ended")
    ways = "; ".join(f"{how}, up to {_place(found, train)}" for how, found in tried)
    return (
        f"no steady train: {reason} (residual {last.iterated.state.residual:.2e} U, wanted"
        f" {tolerance:.0e} U, {iterations} iterations); tried: {ways}"
    )


def _place(followed: Followed, train: Train) -> str:
    """Where a way has ended."""
    where = followed.problem.train
    return "the case itself" if where == train else describe_change(where, train)
