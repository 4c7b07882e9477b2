"""Resting shapes of other reduced volumes, Fig. 17 of Bryngelson & Freund (2018).

The healthy biconcave cell of area A_0 is deflated or inflated to the volume V = v V_0, V_0 = 4 pi/3
(A_0/4 pi)^(3/2) being the largest that its area can hold, and relaxes:

    least E(s) + P(s)   subject to   A(s) = A_0,  V(s) = v V_0,

over axisymmetric shapes with a mirror plane, E the energy of the healthy cell's membrane (Skalak
with the default moduli, bending about the biconcave shape; the minimum depends on ratios of moduli
only). The shape that is found is then free of stress: another cell's rest.

P keeps the faces of the thinnest cells apart while they form (see `relaxation`).

The search is by Newton's method from one reduced volume to the next (see `stationary`), which also
gives the derivative of a shape by v.
"""

from dataclasses import replace
from functools import cache
from math import copysign, pi, sqrt, trunc

import numpy as np

from celltrain.harmonics import Shape, coefficients_of, profile_of
from celltrain.membrane.reference import reference_coefficients
from celltrain.membrane.relaxation import Relaxation, relaxation
from celltrain.membrane.stationary import Unknowns, least_energy, minimum_slope
from celltrain.parameters import CaseError

#: Change of the reduced volume from one minimum to the next.
VOLUME_STEP = 0.02
#: Closer to 1 than this the shape is the sphere, to which it tends like sqrt(1 - v).
NEARLY_ONE = 1e-6
#: Largest part of the forces, in mu U r0, that the constraints do not balance.
LARGEST_IMBALANCE = 1e-9


@cache
def relaxed_shape(degree: int, reduced_volume: float) -> Shape:
    """Coefficients of the resting cell of a reduced volume v, its axis the tube's, its centre at 0.

    **Raises:** `CaseError` if no minimum was found.
    """
    problem = relaxation(degree)
    area, _, healthy = _healthy(problem)
    if reduced_volume > 1.0 - NEARLY_ONE:
        shape = sqrt(area / (4.0 * pi)) * reference_coefficients(degree, "sphere")
    else:
        start = _rung(degree, trunc((reduced_volume - healthy) / VOLUME_STEP))
        shape = coefficients_of(problem.profile(_minimum(problem, start, reduced_volume)))
    shape.setflags(write=False)
    return shape


@cache
def relaxed_slope(degree: int, reduced_volume: float) -> Shape:
    """Derivative of `relaxed_shape` by the reduced volume, r0.

    **Raises:** `CaseError` next to the sphere, where it becomes infinite, or if there is no shape.
    """
    if reduced_volume > 1.0 - NEARLY_ONE:
        raise CaseError(
            f"reduced_volume = {reduced_volume:g} is not allowed: the shape at rest has no"
            " derivative there; allowed: < 1"
        )
    problem = relaxation(degree)
    _, largest, _ = _healthy(problem)
    unknowns = problem.unknowns(profile_of(relaxed_shape(degree, reduced_volume)))
    slope = minimum_slope(problem, unknowns, np.array([0.0, largest]))
    shape = coefficients_of(problem.profile(slope))
    shape.setflags(write=False)
    return shape


def healthy_reduced_volume(degree: int) -> float:
    """The reduced volume of the biconcave cell itself, 0.6444, by the rule of a degree."""
    return _healthy(relaxation(degree))[2]


def contact_volume(degree: int) -> float:
    """The reduced volume below which faces would meet if nothing kept them apart.

    The deflation is followed without repulsion until the thickness at some point is zero.
    """
    problem = replace(relaxation(degree), repulsion=0.0)
    unknowns = problem.unknowns(problem.membrane.rest_profile)
    *_, v = _healthy(problem)
    thinnest = problem.least_thickness(unknowns)
    while True:
        following = v - 0.5 * VOLUME_STEP
        unknowns = _minimum(problem, unknowns, following)
        before, thinnest = thinnest, problem.least_thickness(unknowns)
        if thinnest <= 0.0:
            return following + (v - following) * -thinnest / (before - thinnest)
        v = following


@cache
def _rung(degree: int, count: int) -> Unknowns:
    """The shape a number of steps (negative: of deflation) away from the healthy one."""
    problem = relaxation(degree)
    if count == 0:
        return problem.unknowns(problem.membrane.rest_profile)
    *_, healthy = _healthy(problem)
    before = _rung(degree, count - int(copysign(1, count)))
    return _minimum(problem, before, healthy + count * VOLUME_STEP)


def _healthy(problem: Relaxation) -> tuple[float, float, float]:
    """Area of the healthy cell, the largest volume that it can hold, and the reduced volume."""
    rest = problem.membrane.rest_profile
    area, volume = problem.membrane.area(rest), problem.membrane.volume(rest)
    largest = area**1.5 / (6.0 * sqrt(pi))
    return area, largest, volume / largest


def _minimum(problem: Relaxation, start: Unknowns, reduced_volume: float) -> Unknowns:
    """Least energy at the healthy cell's area and a reduced volume, from a shape nearby."""
    area, largest, _ = _healthy(problem)
    target = np.array([area, reduced_volume * largest])
    unknowns = least_energy(problem, start, target)
    left = float(np.abs(problem.derivatives(unknowns).imbalance).max())
    if not (left < LARGEST_IMBALANCE and np.abs(problem.held(unknowns) - target).max() < 1e-9):
        raise CaseError(
            f"reduced_volume = {reduced_volume:g} is not allowed at degree {problem.degree}: no"
            f" resting shape was found (forces of {left:.1e} mu U r0 are not balanced); take"
            " another degree"
        )
    return unknowns
