"""Minima of an energy with some quantities held: Newton's method, and how they change.

A minimum u of E at h(u) = c has multipliers l with grad E - N^T l = 0, N = grad h. Newton's method
for both, and the derivative of u by c, are solutions of linear systems with one matrix,

    [ H   -N^T ] [ du ]   [ -(grad E - N^T l) ]             [ H   -N^T ] [ du/dc ]   [ 0 ]
    [ N    0   ] [ dl ] = [ c - h             ]      and    [ N    0   ] [ dl/dc ] = [ 1 ],

H = hess E - l . hess h.
"""

from typing import Protocol, runtime_checkable

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

# Corrections of a guess that is good already: they converge quadratically.
CORRECTIONS = 4

Unknowns = Float[Array, " unknown"]
Held = Float[Array, " held"]


@runtime_checkable
class HeldEnergy(Protocol):
    """An energy and the quantities held, as functions of some unknowns; a pytree."""

    def energy(self, unknowns: Unknowns) -> Float[Array, ""]:
        """What is least."""

    def held(self, unknowns: Unknowns) -> Held:
        """What is held."""


def corrected_minimum(
    problem: HeldEnergy, unknowns: Float[np.ndarray, " unknown"], target: Float[np.ndarray, " held"]
) -> Float[np.ndarray, " unknown"]:
    """A minimum to rounding, from one that is nearly there; the guess itself if that fails."""
    best, error = unknowns, np.inf
    place = unknowns
    for _ in range(CORRECTIONS + 1):
        unbalanced, held, matrix = _conditions(problem, place)
        wrong = np.append(unbalanced, held - target)
        left = float(np.abs(wrong).max())
        if not left < error:
            break
        best, error = place, left
        place = place - np.linalg.solve(matrix, wrong)[: len(place)]
    return best


def minimum_slope(
    problem: HeldEnergy,
    unknowns: Float[np.ndarray, " unknown"],
    held_slope: Float[np.ndarray, " held"],
) -> Float[np.ndarray, " unknown"]:
    """Derivative of a minimum as the held quantities change by `held_slope`."""
    *_, matrix = _conditions(problem, unknowns)
    right = np.append(np.zeros_like(unknowns), held_slope)
    return np.linalg.solve(matrix, right)[: len(unknowns)]


def _conditions(
    problem: HeldEnergy, unknowns: Float[np.ndarray, " unknown"]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What the held quantities do not balance, these, and the matrix of the module."""
    parts = _derivatives(problem, jnp.asarray(unknowns))
    gradient, curvature, held, normals, bends = (np.asarray(part) for part in parts)
    # The multipliers that suit the place best.
    multipliers = np.linalg.lstsq(normals.T, gradient)[0]
    hessian = curvature - np.tensordot(multipliers, bends, axes=1)
    count = len(held)
    matrix = np.block([[hessian, -normals.T], [normals, np.zeros((count, count))]])
    return gradient - normals.T @ multipliers, held, matrix


@eqx.filter_jit
def _derivatives(problem: HeldEnergy, unknowns: Unknowns) -> tuple[Array, ...]:
    return (
        jax.grad(problem.energy)(unknowns),
        jax.hessian(problem.energy)(unknowns),
        problem.held(unknowns),
        jax.jacfwd(problem.held)(unknowns),
        jax.jacfwd(jax.jacrev(problem.held))(unknowns),
    )
