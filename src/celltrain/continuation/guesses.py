"""First guesses for other steady trains of a case: shapes of cells in tubes, and trains nearby.

In a tube whose wall is near to the cell at rest that is squeezed to a part of the tube's radius,
rho -> s rho, z -> z/s^2. Bent cells are z -> z + b cos^2 theta, which keeps the volume. Bullets are
ellipsoids, bent so that the rear pole lies behind the rear rim, or ahead of it as in a parachute.
Trains nearby are those of the case's branch at other parameters, each reached by a path of bounded
length.
"""

import math
from collections.abc import Iterator

import numpy as np

from celltrain.harmonics import UNIT_DISPLACEMENT, Profile
from celltrain.meridian.geometry import largest_radius
from celltrain.parameters import CaseError, Train
from celltrain.steady import Base
from celltrain.steady.parameters import parameter_value
from celltrain.steady.path import follow
from celltrain.steady.problem import SteadyProblem, change_of_profile

# The part of the tube's radius to which shapes are squeezed that are wider.
FITTING = 0.8
# Displacements of the poles (r0) of a bent cell.
BENT = (0.6, -0.6, 1.2, -1.2)
# Ellipsoids: how they are called, their radius (r0) at most, and how much they are bent, relative
# to half of their length: the rear is flat at 0.5, the pole as far as the middle at 1, and the
# hollow half as deep as the cell is long at 2.92.
ELLIPSOIDS = (
    ("a bullet", 0.8, 0.25),
    ("a bullet with a dimple", 0.9, 0.75),
    ("a parachute", 1.3, 3.0),
)
# Parameters, and the factors at which other trains are guesses.
NEARBY = {"packing": (0.7, 1.4), "diameter": (0.9, 1.15), "capillary_number": (0.3, 3.0)}
# Newton's steps that a path to one of them may take, and the size of what is left there, U.
MOST_ITERATIONS, LOOSE = 40, 1e-6
# Sizes (r0) of random disturbances, and the degree up to which harmonics are disturbed.
DISTURBED, LOWEST = (0.2, 0.2, 0.5, 0.5), 5


def first_guesses(known: Base) -> Iterator[tuple[str, Profile]]:
    """The guesses with their names; trains nearby are computed as they are needed."""
    train, profile = known.train, known.profile
    problem = SteadyProblem(train)
    rest = problem.rest
    widest = FITTING * train.radius
    fitting = squeezed(rest, widest)
    name = "the resting shape" if fitting is rest else "the resting shape squeezed to fit"
    yield name, fitting
    for bend in BENT:
        yield f"{name}, bent by {bend:+g} r0", bent(fitting, bend)
    for name, wide, bend in ELLIPSOIDS:
        width = min(wide, widest)
        half = 0.75 * problem.target_volume / (math.pi * width**2)
        yield name, bent(_ellipsoid(train.degree, width, half), bend * half)
    yield "the known one pointing the other way", reversed_profile(profile)
    here = largest_radius(profile)
    for parameter, factors in NEARBY.items():
        for factor in factors:
            value = factor * parameter_value(train, parameter)
            other = _nearby(known, train, {parameter: value})
            if other is not None:
                yield f"the train at {parameter} {value:.3g}", squeezed(other, max(widest, here))
    random = np.random.default_rng(0)
    degrees = np.tile(np.arange(1, train.degree), 2)
    for number, size in enumerate(DISTURBED, 1):
        amounts = random.normal(size=len(degrees)) * (degrees <= LOWEST)
        amounts *= size * UNIT_DISPLACEMENT / np.linalg.norm(amounts)
        disturbed = profile + change_of_profile(amounts)
        yield f"the known one disturbed by {size:g} r0 (draw {number})", disturbed


def squeezed(profile: Profile, radius: float) -> Profile:
    """A shape no wider than a radius (r0) with the same volume; itself if it is not."""
    part = radius / largest_radius(profile)
    if part >= 1.0:
        return profile
    return profile * np.array([[part**-2], [part]])


def bent(profile: Profile, bend: float) -> Profile:
    """A shape bent by z -> z + b cos^2 theta, b in r0, but for a displacement."""
    changed = profile.copy()
    # z of P_20 at the pole, less that at the equator, is the bend.
    changed[0, 2] += bend / (1.5 * math.sqrt(5.0 / (4.0 * math.pi)))
    return changed


def reversed_profile(profile: Profile) -> Profile:
    """The mirror image z -> -z of a shape, front pole to rear pole."""
    # P_nm(pi - theta) = (-1)^(n + m) P_nm(theta), and z changes its sign.
    return profile * (-1.0) ** (1 + np.arange(profile.shape[1]))


def _ellipsoid(degree: int, width: float, half: float) -> Profile:
    """rho = w sin(theta), z = l cos(theta)."""
    profile = np.zeros((2, degree))
    profile[0, 1] = half * math.sqrt(4.0 * math.pi / 3.0)
    profile[1, 1] = width * math.sqrt(8.0 * math.pi / 3.0)
    return profile


def _nearby(known: Base, train: Train, change: dict[str, float]) -> Profile | None:
    """The shape of the train with another parameter; None where the path does not lead there."""
    try:
        end = train.changed(**change)
        found = follow(train, known.profile, end, tolerance=LOOSE, most=MOST_ITERATIONS)
    except CaseError:
        return None
    return found.iterated.state.profile if found.complete else None
