"""The equations of steady trains as curves and searches take them.

Unknowns are those of a steady train (see `steady.problem`) in units of a displacement by one r0,
a/sqrt(4 pi), and the multiplier c that takes the place of the equation which follows from the
others; c = 0 in a solution. The equations are

    F(a, c) = [ v(a) - c n,  V(a) - V0 ],      n = dV/da.

Rules stay those of the point before while they serve, so that they do not jump in the middle of a
correction.
"""

import math
from dataclasses import dataclass

import numpy as np

from celltrain.continuation.arclength import Evaluation, NoSolution, Unknowns
from celltrain.harmonics import UNIT_DISPLACEMENT, Profile
from celltrain.meridian.geometry import meridian_points
from celltrain.steady.base import Base
from celltrain.steady.iterate import Iterated
from celltrain.steady.problem import SteadyProblem, SteadyState, change_of_profile, unknowns_of
from celltrain.steady.solve import describe

# Of a meridian.
POINTS = 201


@dataclass(frozen=True)
class SteadyPoint:
    """A shape of a train's cells, steady or on the way to it."""

    problem: SteadyProblem
    state: SteadyState

    def base(self, origin: str) -> Base:
        """What is reported of it as a steady train."""
        return describe(self.problem, Iterated(self.state, (), "steady"), origin)


def known_point(base: Base) -> SteadyPoint:
    """That of a steady train."""
    problem = SteadyProblem(base.train)
    return SteadyPoint(problem, problem.state(base.profile))


def to_unknowns(profile: Profile) -> Unknowns:
    """(a/sqrt(4 pi), c = 0) of a shape."""
    return np.append(unknowns_of(profile) / UNIT_DISPLACEMENT, 0.0)


def evaluate_steady(
    problem: SteadyProblem, unknowns: Unknowns, near: SteadyPoint, *, most_work: float = math.inf
) -> Evaluation[SteadyPoint]:
    """F, its derivatives in the unknowns, and the shape that belongs to them.

    **Arguments:** `most_work`: what an evaluation may take (see `Rules.work`).

    **Raises:** `NoSolution` where cells overlap each other or the wall, or come so close that an
    evaluation would take more.
    """
    profile = change_of_profile(UNIT_DISPLACEMENT * unknowns[:-1])
    # Searches come across meridians beyond the axis, whose distance from the wall is on that side.
    radius = meridian_points(profile, POINTS)[0]
    if not (problem.fits(profile) and radius.min() > -radius.max()):
        raise NoSolution("cells overlap")
    rules = problem.rules(profile)
    if near.state.flow.rules.covers(rules):
        rules = near.state.flow.rules
    elif rules.work > most_work:
        raise NoSolution("cells all but touch, or are drawn out too far")
    state = problem.state(profile, rules)
    rates, normal = state.rates, state.volume_gradient
    size = len(rates)
    jacobian = np.zeros((size + 1, size + 1))
    jacobian[:size, :size] = UNIT_DISPLACEMENT * state.jacobian
    jacobian[:size, size] = -normal
    jacobian[size, :size] = UNIT_DISPLACEMENT * normal
    return Evaluation(
        residual=np.append(rates - unknowns[-1] * normal, -state.missing_volume),
        jacobian=jacobian,
        error=state.error,
        state=SteadyPoint(problem, state),
    )
