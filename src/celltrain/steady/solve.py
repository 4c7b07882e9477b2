"""Steady trains: pseudo-transient continuation from rest, then Newton's method.

Implicit Euler steps with the exact Jacobian follow the train's own dynamics from the given shape,
so the branch that is found is the one that marching finds; the step doubles while the shape moves
little, until Newton's method takes over (Kelley & Keyes 1998).
"""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Literal

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from celltrain.parameters import Train
from celltrain.runtime import timed
from celltrain.steady.base import Base, Iteration, NotConverged
from celltrain.steady.system import State, SteadySystem, bordered_step, steady_system
from celltrain.train import largest_radius, streamwise_gap

TOLERANCE = 1e-9
FIRST_STEP = 0.3
# Largest displacement (r0) of a membrane point in one step of the march.
LARGEST_MOVE = 0.4
SMALLEST_STEP = 1e-4
# Newton's method takes over when the residual is below this, and gives up its turn when it rises.
NEWTON_RESIDUAL = 2e-2

Progress = Callable[[Iteration], None]


def steady(
    train: Train,
    *,
    start: Base | None = None,
    tolerance: float = TOLERANCE,
    max_iterations: int = 80,
    progress: Progress | None = None,
) -> Base:
    """The steady train that the flow reaches from rest, or from another steady train.

    **Arguments:**

    - `train`: what to compute; the number of cells does not matter here.
    - `start`: a solution at other parameters, followed to these ones: its shape is the first guess,
      with the resting shape of `train` unchanged. Its degree may differ.
    - `tolerance`: bound on the residual, in U. 1e-9 is reached in all cases tried; what remains
      then is the roundoff of the sums.
    - `progress`: called after every iteration.

    **Returns:** a `Base`.

    **Raises:** `NotConverged`, which carries the last state and the history.
    """
    seconds: dict[str, float] = {}
    with timed(seconds, "base"):
        base, converged = _find(train, start, tolerance, max_iterations, progress)
    base = replace(base, seconds=seconds)
    if not converged:
        raise NotConverged(_complaint(base, tolerance, max_iterations), base)
    if base.gap <= 0.0:
        raise NotConverged(f"neighbouring cells overlap: gap = {base.gap:.3g} r0", base)
    return base


def _find(
    train: Train,
    start: Base | None,
    tolerance: float,
    max_iterations: int,
    progress: Progress | None,
) -> tuple[Base, bool]:
    """The last state of the iteration, and whether it is steady."""
    system = steady_system(train)
    rest = np.asarray(system.operator.membrane.reference_shape)
    guess = rest if start is None else change_degree(start.coefficients, train.resolution.degree)
    target_volume = float(system.operator.membrane.volume(jnp.asarray(rest)))
    unknowns = np.array(system.unknowns(jnp.asarray(guess)))
    state = system.state(jnp.asarray(unknowns))
    history: list[Iteration] = []
    # A nearby solution needs no march: full steps, unless they turn out to be too long.
    time_step = FIRST_STEP if start is None else math.inf
    converged = False
    while len(history) < max_iterations:
        residual = float(state.residual)
        volume_error = abs(float(state.volume) - target_volume)
        converged = residual < tolerance and volume_error < tolerance
        if converged or not math.isfinite(residual):
            break
        if residual < NEWTON_RESIDUAL:
            time_step = math.inf
        unknowns, state, time_step, step = _advance(
            system, unknowns, state, target_volume, time_step
        )
        history.append(step)
        if progress is not None:
            progress(step)
        if step.step < SMALLEST_STEP:
            break
    origin = "march from the resting shape"
    if start is not None:
        origin = f"continuation from {describe_change(start.train, train)}"
    return _describe(system, train, unknowns, state, tuple(history), origin), converged


def _advance(
    system: SteadySystem,
    unknowns: Float[np.ndarray, " unknown"],
    state: State,
    target_volume: float,
    time_step: float,
) -> tuple[Float[np.ndarray, " unknown"], State, float, Iteration]:
    """One accepted step, shortened until the shape moves little enough and the residual holds."""
    residual = float(state.residual)
    while True:
        change = bordered_step(state, target_volume, time_step)
        on_grid = np.asarray(
            system.operator.target_grid.values @ system.shape(jnp.asarray(change)).T
        )
        moved = float(np.linalg.norm(on_grid, axis=-1).max())
        if math.isfinite(moved) and moved < LARGEST_MOVE:
            candidate = unknowns + change
            following = system.state(jnp.asarray(candidate))
            growth = float(following.residual) / residual
            # The march may pass through larger residuals; Newton's method may not.
            if growth < (1.0 if math.isinf(time_step) else 3.0) or residual < 1e-6:
                break
        if time_step < SMALLEST_STEP:
            candidate, following, moved = unknowns, state, 0.0
            break
        time_step = 1.0 if math.isinf(time_step) else 0.5 * time_step
    method: Literal["march", "newton"] = "newton" if math.isinf(time_step) else "march"
    step = Iteration(method, residual, time_step, float(state.cell_velocity))
    if moved < 0.5 * LARGEST_MOVE:
        time_step *= 2.0
    return candidate, following, time_step, step


def _describe(
    system: SteadySystem,
    train: Train,
    unknowns: Float[np.ndarray, " unknown"],
    state: State,
    history: tuple[Iteration, ...],
    origin: str,
) -> Base:
    shape = np.asarray(system.shape(jnp.asarray(unknowns)))
    viscosity = system.operator.effective_viscosity(jnp.asarray(shape)[None])
    return Base(
        train=train,
        coefficients=shape,
        cell_velocity=float(state.cell_velocity),
        gap=streamwise_gap(shape, train.period),
        largest_radius=largest_radius(shape),
        effective_viscosity=float(viscosity),
        residual=float(state.residual),
        truncation_error=float(system.truncation_error(jnp.asarray(unknowns))),
        history=history,
        origin=origin,
        seconds={},
    )


def _complaint(base: Base, tolerance: float, max_iterations: int) -> str:
    count = len(base.history)
    reason = (
        f"{max_iterations} iterations were not enough"
        if count >= max_iterations
        else "the residual is not a number"
        if not math.isfinite(base.residual)
        else "the step became too short"
    )
    return (
        f"no steady train: {reason} (iteration {count}, residual {base.residual:.2e} U, "
        f"wanted {tolerance:.0e} U)"
    )


def change_degree(
    shape: Float[np.ndarray, "3 coefficient"], degree: int
) -> Float[np.ndarray, "3 other"]:
    """Coefficients cut or padded with zeros to another degree."""
    changed = np.zeros((3, degree * degree))
    count = min(shape.shape[-1], degree * degree)
    changed[:, :count] = shape[:, :count]
    return changed


def describe_change(old: Train, new: Train) -> str:
    """The leaves in which two trains differ, with the old values: "packing = 0.2"."""
    before, after = old.leaves(), new.leaves()
    changes = [f"{name} = {value}" for name, value in before.items() if after[name] != value]
    return ", ".join(changes) or "the same case"
