"""Minima of an energy with some quantities held: Newton's method, and how they change.

A minimum u of E at h(u) = c has multipliers l with grad E - N^T l = 0, N = grad h. Newton's method
for both, and the derivative of u by c, are solutions of linear systems with one matrix,

    [ H   -N^T ] [ du ]   [ -(grad E - N^T l) ]             [ H   -N^T ] [ du/dc ]   [ 0 ]
    [ N    0   ] [ dl ] = [ c - h             ]      and    [ N    0   ] [ dl/dc ] = [ 1 ],

H = hess E - l . hess h. Far from the minimum, H is made positive definite on the tangent space (its
eigenvalues there are replaced by their sizes), and steps are shortened until E + mu |h - c| falls
(*Nocedal & Wright 2006*, ch. 18).
"""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
import scipy.linalg
from jaxtyping import Float

# Steps at most; from one shape to the next of a family it takes about five.
STEPS = 60
# Halvings of a step at most.
HALVINGS = 12
# Part of the decrease that the slope promises with which a step must come up.
SUFFICIENT = 1e-4
# Smallest eigenvalue on the tangent space, relative to the largest, that a step divides by.
LEAST_STIFFNESS = 1e-8

Unknowns = Float[np.ndarray, " unknown"]
Held = Float[np.ndarray, " held"]


@dataclass(frozen=True)
class Derivatives:
    """Of an energy, and of the quantities held, at one place."""

    gradient: Unknowns
    hessian: Float[np.ndarray, "unknown unknown"]
    normals: Float[np.ndarray, "held unknown"]
    bends: Float[np.ndarray, "held unknown unknown"]

    @property
    def multipliers(self) -> Held:
        """Those that balance the energy's gradient best."""
        return np.linalg.lstsq(self.normals.T, self.gradient)[0]

    @property
    def imbalance(self) -> Unknowns:
        """The energy's gradient less what the held quantities balance; nothing at a minimum."""
        return self.gradient - self.normals.T @ self.multipliers

    @property
    def curvature(self) -> Float[np.ndarray, "unknown unknown"]:
        """H of the module."""
        return self.hessian - np.tensordot(self.multipliers, self.bends, axes=1)


@runtime_checkable
class HeldEnergy(Protocol):
    """An energy and the quantities held, as functions of some unknowns."""

    def energy(self, unknowns: Unknowns) -> float:
        """What is least."""
        ...

    def held(self, unknowns: Unknowns) -> Held:
        """What is held."""
        ...

    def derivatives(self, unknowns: Unknowns) -> Derivatives:
        """Derivatives of both."""
        ...


def least_energy(problem: HeldEnergy, start: Unknowns, target: Held) -> Unknowns:
    """The minimum near a place, to rounding; wherever the search ends if it finds none."""
    place, here = start, problem.derivatives(start)
    left = _left(problem, place, here, target)
    for _ in range(STEPS):
        step, convex = _step(here, problem.held(place) - target)
        following = place + step
        there = problem.derivatives(following)
        rest = _left(problem, following, there, target)
        # Newton's method itself, as soon as it converges.
        if not (convex and rest < 0.5 * left):
            if convex and left < 1e-10:
                break
            following = _shortened(problem, place, here, step, target)
            there = problem.derivatives(following)
            rest = _left(problem, following, there, target)
        place, here, left = following, there, rest
    return place


def minimum_slope(problem: HeldEnergy, unknowns: Unknowns, held_slope: Held) -> Unknowns:
    """Derivative of a minimum as the held quantities change by `held_slope`."""
    here = problem.derivatives(unknowns)
    count = len(held_slope)
    matrix = np.block([[here.curvature, -here.normals.T], [here.normals, np.zeros((count, count))]])
    right = np.append(np.zeros_like(unknowns), held_slope)
    return np.linalg.solve(matrix, right)[: len(unknowns)]


def _left(problem: HeldEnergy, place: Unknowns, here: Derivatives, target: Held) -> float:
    """How far a place is from a minimum."""
    wrong = np.append(here.imbalance, problem.held(place) - target)
    return float(np.abs(wrong).max())


def _step(here: Derivatives, missed: Held) -> tuple[Unknowns, bool]:
    """Newton's step, made a descent, and whether it was one already."""
    across = -np.linalg.lstsq(here.normals, missed)[0]
    tangents = scipy.linalg.null_space(here.normals)
    curvature = here.curvature
    stiffness, directions = np.linalg.eigh(tangents.T @ curvature @ tangents)
    convex = bool(stiffness[0] > 0.0)
    size = np.abs(stiffness)
    size = np.maximum(size, LEAST_STIFFNESS * size.max())
    pull = tangents.T @ (here.gradient + curvature @ across)
    return across - tangents @ (directions @ (directions.T @ pull / size)), convex


def _shortened(
    problem: HeldEnergy, place: Unknowns, here: Derivatives, step: Unknowns, target: Held
) -> Unknowns:
    """A place on the way of a step at which the energy, and what is missed, have fallen."""
    weight = 2.0 * np.abs(here.multipliers).max() + 1.0

    def merit(unknowns: Unknowns) -> float:
        missed = np.abs(problem.held(unknowns) - target).sum()
        return problem.energy(unknowns) + weight * float(missed)

    before = merit(place)
    missed = np.abs(problem.held(place) - target).sum()
    slope = min(float(here.gradient @ step - weight * missed), 0.0)
    part = 1.0
    for _ in range(HALVINGS):
        if merit(place + part * step) <= before + SUFFICIENT * part * slope:
            break
        part *= 0.5
    return place + part * step
