"""Branches of steady trains in one parameter, through folds.

The unknowns are those of a steady train (see `equations`) and one of its parameters p. The curve of

    F(a, p, c) = [ v(a, p) - c n,  V(a) - V0(p) ]

is followed by its arclength in a/sqrt(4 pi) (r0) and p/p0, p0 its first value. It ends where cells
all but touch each other or the wall: what a train takes grows there without bound.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Annotated, ClassVar

import numpy as np

from celltrain.continuation.arclength import (
    CurveEnding,
    CurveLost,
    CurvePoint,
    Evaluation,
    NoSolution,
    Steps,
    Unknowns,
    trace_curve,
)
from celltrain.continuation.equations import (
    SteadyPoint,
    evaluate_steady,
    known_point,
    to_unknowns,
)
from celltrain.harmonics import UNIT_DISPLACEMENT
from celltrain.parameters import CaseError, Train
from celltrain.proximity.meridian import clearance, crosses_itself
from celltrain.quantities import Quantity, Record, quantity
from celltrain.stability import Mode, Stability
from celltrain.steady import Base
from celltrain.steady.parameters import PARAMETERS, parameter_value, parameters_of
from celltrain.steady.path import follow
from celltrain.steady.problem import SteadyProblem, change_of_profile
from celltrain.steady.room import check_room
from celltrain.steady.sensitivity import rates_by_parameter
from celltrain.steady.solve import describe
from celltrain.steady.varied import VariedTrain

#: Parameters along which there are branches: steady trains do not depend on the viscosity ratio.
ALONG = tuple(name for name in PARAMETERS if name != "viscosity_ratio")

# A branch ends after a train that takes more than this many times what its first one takes, and
# passes by those that take so many times more than that.
MOST_WORK, BEYOND = 64, 4
# Newton's steps on the way to the train at the last value itself.
MOST_ITERATIONS = 60

Dynamics = Callable[[Base], Stability]


@dataclass(frozen=True, eq=False)
class BranchPoint(Record):
    """A steady train of a branch, with its leading mode if that was asked for.

    `slope` is dp/d(arclength) relative to the first value of p; it changes its sign at a fold.
    """

    base: Base
    value: Annotated[float, Quantity("p", "", "value of the parameter")]
    slope: Annotated[
        float, Quantity("dp/ds", "1", "change of the parameter with the arclength, relative")
    ]
    leading: Mode | None

    @property
    @quantity(Quantity(r"\alpha", "U/r0", "largest growth rate, NaN if not computed"))
    def growth_rate(self) -> float:
        """Spectral abscissa, in U/r0; NaN if it was not computed."""
        return math.nan if self.leading is None else self.leading.growth_rate


@dataclass(frozen=True, eq=False)
class Branch(Record):
    """The steady trains found along a branch, in order, and why there are no more."""

    kind: ClassVar[str] = "branch"
    title: ClassVar[str] = "branch of steady trains along a parameter"

    parameter: Annotated[str, Quantity("p", "1", "the parameter that changes")]
    points: tuple[BranchPoint, ...]
    ending: CurveEnding

    @property
    def base(self) -> Base:
        """The last steady train."""
        return self.points[-1].base

    @property
    @quantity(Quantity("", "1", "numbers of the points after which the parameter turns back"))
    def folds(self) -> tuple[int, ...]:
        """Numbers of the points after which the parameter turns back."""
        signs = np.sign([point.slope for point in self.points])
        return tuple(int(i) for i in np.flatnonzero(signs[1:] * signs[:-1] < 0.0))


def branch(
    start: Base,
    parameter: str,
    *,
    to: float,
    steps: Steps | None = None,
    analyse: Dynamics | None = None,
    most_points: int = 100,
    progress: Callable[[BranchPoint], None] | None = None,
) -> Branch:
    """The branch of steady trains through a known one, up to a value of a parameter.

    What was found is kept when the branch ends early, also by an interruption (`Branch.ending`).

    **Arguments:**

    - `parameter`: one of `ALONG`.
    - `to`: its last value. A branch that turns back at a fold ends at the first value again, and
      one whose cells come to touch before it reaches the value where they nearly do.
    - `steps`: how it is followed.
    - `analyse`: from each steady train its linear dynamics, such as `stability`.
    - `progress`: called with every point.

    **Raises:** `CaseError` for a parameter or a value that is not allowed.
    """
    points: list[BranchPoint] = []
    followed = follow_branch(start, parameter, to=to, steps=steps, analyse=analyse)
    ending = CurveEnding("enough", f"{most_points} points were found")
    try:
        for point in followed:
            points.append(point)
            if progress is not None:
                progress(point)
            if len(points) >= most_points:
                break
        else:
            ending = CurveEnding("reached", f"{parameter} = {to:g} is reached")
            if points[-1].value != to:
                ending = CurveEnding("turned back", "the branch turned back to its first value")
    except CurveLost as failure:
        where = f"the last train is at {parameter} = {points[-1].value:.6g}: " if points else ""
        ending = CurveEnding("lost", f"{where}{failure}")
    except KeyboardInterrupt:
        ending = CurveEnding("interrupted", "interrupted")
    return Branch(parameter, tuple(points), ending)


def follow_branch(
    start: Base,
    parameter: str,
    *,
    to: float,
    steps: Steps | None = None,
    analyse: Dynamics | None = None,
) -> Iterator[BranchPoint]:
    """The points of `branch` one by one, as they are found.

    **Raises:** `CaseError` as `branch` does; `CurveLost` when no further point is found.
    """
    first = check_branch(start.train, parameter, to)
    steps = Steps() if steps is None else steps
    known = known_point(start)
    most = MOST_WORK * known.state.flow.rules.work
    problem = _equations(parameter, first, BEYOND * most)
    origin = f"branch along {parameter} from {first:g}"
    base = start
    # (a/sqrt(4 pi), p/p0, c).
    begin = np.insert(to_unknowns(start.profile), -1, 1.0)
    towards = np.zeros_like(begin)
    towards[-2] = np.sign(to - first)
    for point in trace_curve(problem, begin, towards, known, steps):
        value = first * float(point.unknowns[-2])
        if (value - to) * (to - first) >= 0.0:
            yield _last(base, parameter, to, point, steps, analyse)
            return
        if (value - first) * (to - first) < -1e-9 * first**2:
            return
        base = point.state.base(origin)
        yield _point(base, parameter, value, point, analyse)
        if point.state.problem.rules(base.profile).work > most:
            apart = clearance(base.profile, base.train.period, base.train.radius)
            raise CurveLost(f"the cells are {apart:.2g} r0 from each other or the wall")


def check_branch(train: Train, parameter: str, to: float) -> float:
    """Check that there can be such a branch; returns the first value of the parameter.

    **Raises:** `CaseError` for what is not allowed.
    """
    allowed = [name for name in ALONG if name in parameters_of(train)]
    if parameter not in allowed:
        raise CaseError(f"parameter = {parameter!r} is not allowed; allowed: {', '.join(allowed)}")
    first = parameter_value(train, parameter)
    check_room(train.changed(**{parameter: to}))
    if to == first or first == 0.0:
        raise CaseError(
            f"to = {to:g} is not allowed: {parameter} is {first:g} at the start; allowed: another"
            " value, with a first one that is not 0"
        )
    return first


def _point(
    base: Base,
    parameter: str,
    value: float,
    point: CurvePoint[SteadyPoint],
    analyse: Dynamics | None,
) -> BranchPoint:
    """What is kept of a train on the branch.

    **Raises:** `CurveLost` if it is none that cells can have.
    """
    if crosses_itself(base.profile):
        raise CurveLost(f"at {parameter} = {value:.6g} the membrane crosses itself")
    leading = None if analyse is None else analyse(base).leading
    return BranchPoint(base, value, float(point.tangent[-2]), leading)


def _last(
    base: Base,
    parameter: str,
    to: float,
    point: CurvePoint[SteadyPoint],
    steps: Steps,
    analyse: Dynamics | None,
) -> BranchPoint:
    """The train at the last value itself, which the curve has just passed."""
    end = base.train.changed(**{parameter: to})
    found = follow(base.train, base.profile, end, tolerance=steps.tolerance, most=MOST_ITERATIONS)
    if not found.complete:
        raise CurveLost(f"{parameter} = {to:g} itself is not reached")
    last = describe(found.problem, found.iterated, base.origin)
    return _point(last, parameter, to, point, analyse)


def _equations(
    parameter: str, first: float, most_work: float
) -> Callable[[Unknowns, SteadyPoint], Evaluation[SteadyPoint]]:
    """F, its derivatives, and the train that belongs to some unknowns."""

    def evaluate(unknowns: Unknowns, near: SteadyPoint) -> Evaluation[SteadyPoint]:
        value = first * float(unknowns[-2])
        try:
            problem = SteadyProblem(near.problem.train.changed(**{parameter: value}))
            found = evaluate_steady(problem, np.delete(unknowns, -2), near, most_work=most_work)
            profile = change_of_profile(UNIT_DISPLACEMENT * unknowns[:-2])
            varied = VariedTrain(problem, profile, parameter)
        except CaseError as error:
            raise NoSolution(str(error)) from None
        rates, volume = rates_by_parameter(varied, profile)
        column = first * np.append(rates, -volume)
        return replace(found, jacobian=np.insert(found.jacobian, -1, column, axis=1))

    return evaluate
