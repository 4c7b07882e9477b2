"""Graded meridians: colatitudes drawn together where a cell of a narrow tube is sharp.

A shape is a function on the parameter sphere, and any smooth parametrisation of the resting cell
serves. In a narrow tube a cell has a rim at its rear, folded around a bending length, and a nose
that the next rim encloses; between them it is a plain cylinder. With theta the colatitude of the
usual resting shape, that of the harmonics is

    psi = theta + grading sum_i w_i [ C_i(theta - theta_i) + C_i(theta + theta_i) - 2 theta ]/2,
    C_i(x) = x + 2 arg(1 - r_i exp(-i x)),

C_i the integral of a Poisson kernel of width 1 - r_i: analytic, odd about both poles, and rising,
so that a graded shape is as smooth as the shape itself.
"""

import numpy as np

from celltrain.harmonics.legendre import legendre_functions
from celltrain.harmonics.profile import Angles, Meridian, Profile, project_meridian

#: Rim and nose: place (radians), sharpness r, and weight w of each.
PLACES = ((2.3, 0.6, 0.4), (0.25, 0.5, 0.3))
# Points between which the inverse is first sought, and Newton's steps from there to rounding.
POINTS, STEPS = 2001, 5


def graded(theta: Angles, grading: float) -> Angles:
    """psi at usual colatitudes theta, radians; `grading` from 0 (psi = theta) to 1."""
    psi = np.array(theta, dtype=float)
    for place, sharpness, weight in PLACES:
        drawn = 0.5 * (_drawn(theta - place, sharpness) + _drawn(theta + place, sharpness))
        psi += grading * weight * drawn
    return psi


def usual(psi: Angles, grading: float) -> Angles:
    """The inverse of `graded`: theta at the colatitudes psi of a graded meridian, radians."""
    known = np.linspace(0.0, np.pi, POINTS)
    theta = np.interp(psi, graded(known, grading), known)
    for _ in range(STEPS):
        theta = theta - (graded(theta, grading) - psi) / _rise(theta, grading)
    return theta


def regraded(profile: Profile, old: float, new: float) -> Profile:
    """A profile of one grading as one of another, of the same degree; linear in the profile."""
    if old == new:
        return profile
    degree = profile.shape[1]

    def meridian(psi: Angles) -> Meridian:
        legendre = legendre_functions(degree, 1, graded(usual(psi, new), old))
        return profile[1] @ legendre[1], profile[0] @ legendre[0]

    return project_meridian(degree, meridian, 4 * degree)


def _drawn(x: Angles, sharpness: float) -> Angles:
    """C(x) - x."""
    return 2.0 * np.arctan2(sharpness * np.sin(x), 1.0 - sharpness * np.cos(x))


def _rise(theta: Angles, grading: float) -> Angles:
    """d psi/d theta."""
    rise = np.ones_like(theta)
    for place, sharpness, weight in PLACES:
        for x in (theta - place, theta + place):
            kernel = (1.0 - sharpness**2) / (1.0 - 2.0 * sharpness * np.cos(x) + sharpness**2)
            rise += 0.5 * grading * weight * (kernel - 1.0)
    return rise
