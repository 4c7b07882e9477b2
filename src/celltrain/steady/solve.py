"""Steady trains: pseudo-transient continuation from rest, then Newton's method.

Implicit Euler steps with the exact Jacobian follow the train's own dynamics from the given shape,
so the branch that is found is the one that marching finds; the step doubles while the shape moves
little, until Newton's method takes over (Kelley & Keyes 1998).
"""

import math
from collections.abc import Callable
from dataclasses import replace

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from celltrain.clock import timed
from celltrain.membrane import resting_shape
from celltrain.parameters import Train
from celltrain.programs import forget_many_programs
from celltrain.steady.base import Base, Iteration, NotConverged
from celltrain.steady.system import State, SteadySystem, bordered_step, steady_system
from celltrain.train import (
    clearance,
    close_distance,
    largest_radius,
    rates_error,
    size_at_rest,
    streamwise_gap,
)

TOLERANCE = 1e-9
FIRST_STEP = 0.3
# Largest displacement (r0) of a membrane point in one step of the march.
LARGEST_MOVE = 0.4
SMALLEST_STEP = 1e-4
# Largest factor by which one step of the march may raise the residual.
LARGEST_RISE = 3.0
# Newton's method takes over when the residual is below this; a step that raises it is given back,
# and the march goes on to a tenth of it.
NEWTON_RESIDUAL = 2e-2

Progress = Callable[[Iteration], None]


def steady(
    train: Train,
    *,
    start: Base | None = None,
    tolerance: float = TOLERANCE,
    max_iterations: int = 80,
    estimate_error: bool = True,
    progress: Progress | None = None,
) -> Base:
    """The steady train that the flow reaches from rest, or from another steady train.

    **Arguments:**

    - `train`: what to compute; the number of cells does not matter here.
    - `start`: a solution at other parameters, followed to these ones: its displacement from its own
      shape at rest is the first guess for that from the one of `train`. Its degree may differ.
    - `tolerance`: bound on the residual, in U. 1e-9 is reached in all cases tried; what remains
      then is the roundoff of the sums.
    - `estimate_error`: estimate the velocity's error with finer rules (else it is not a number).
    - `progress`: called after every iteration.

    **Returns:** a `Base`.

    **Raises:** `NotConverged`, which carries the last state and the history. Steps after which
    cells would overlap are not taken. `CaseError` if the tube has no room for the cells at rest,
    which for cells of another reduced volume is only known here.
    """
    forget_many_programs()
    seconds: dict[str, float] = {}
    with timed(seconds, "base"):
        base, converged = _find(train, start, tolerance, max_iterations, progress)
    base = replace(base, seconds=seconds)
    if not converged:
        raise NotConverged(_complaint(base, tolerance, max_iterations), base)
    if estimate_error:
        with timed(seconds, "velocity_error"):
            shape = base.coefficients[None]
            close = comes_close(train, base.coefficients)
            error = rates_error(train, shape, axisymmetric=True, close=close)
        base = replace(base, velocity_error=error)
    return base


def _find(
    train: Train,
    start: Base | None,
    tolerance: float,
    max_iterations: int,
    progress: Progress | None,
) -> tuple[Base, bool]:
    """The last state of the iteration, and whether it is steady."""
    diameter, thickness = size_at_rest(resting_shape(train.cell, train.resolution.degree))
    # A train that follows from another one need not have room at rest.
    train.check_room(diameter, thickness if start is None else 0.0)
    system = steady_system(
        train, close=start is not None and comes_close(train, start.coefficients)
    )
    rest = np.asarray(system.operator.membrane.reference_shape)
    guess = rest if start is None else _carried(start, rest)
    target_volume = float(system.operator.membrane.volume(jnp.asarray(rest)))
    unknowns = np.array(system.unknowns(jnp.asarray(guess)))
    state = system.state(jnp.asarray(unknowns))
    history: list[Iteration] = []
    time_step = FIRST_STEP
    # A nearby solution needs no march, unless Newton's method turns out to fail.
    newton_below = NEWTON_RESIDUAL if start is None else math.inf
    converged = False
    while len(history) < max_iterations and time_step >= SMALLEST_STEP:
        residual = float(state.residual)
        volume_error = abs(float(state.volume) - target_volume)
        converged = residual < tolerance and volume_error < tolerance
        if converged and system.operator.tube.close is None:
            shape = np.asarray(system.shape(jnp.asarray(unknowns)))
            if comes_close(train, shape):
                # The rules for cells at a distance have brought it near to the solution.
                system = steady_system(train, close=True)
                state = system.state(jnp.asarray(unknowns))
                continue
        if converged or not math.isfinite(residual):
            break
        newton = residual < newton_below
        step = math.inf if newton else time_step
        change = bordered_step(state, target_volume, step)
        moved = _largest_move(system, change)
        following = state
        accepted = moved < LARGEST_MOVE
        if accepted:
            following = system.state(jnp.asarray(unknowns + change))
            # The march may pass through larger residuals; Newton's method may not, unless it
            # only corrects the volume.
            rise = 1.0 if newton and residual > 1e-6 else LARGEST_RISE
            accepted = float(following.residual) < rise * residual
            shape = np.asarray(system.shape(jnp.asarray(unknowns + change)))
            accepted = accepted and streamwise_gap(shape, train.period) > 0.0
        if not accepted:
            if newton:
                newton_below = 0.1 * residual
            else:
                time_step *= 0.5
            continue
        history.append(
            Iteration("newton" if newton else "march", residual, step, float(state.cell_velocity))
        )
        unknowns, state = unknowns + change, following
        if not newton and moved < 0.5 * LARGEST_MOVE:
            time_step *= 2.0
        if progress is not None:
            progress(history[-1])
    origin = "march from the resting shape"
    if start is not None:
        origin = f"continuation from {describe_change(start.train, train)}"
    return describe(system, train, unknowns, state, tuple(history), origin), converged


def _carried(
    start: Base, rest: Float[np.ndarray, "3 coefficient"]
) -> Float[np.ndarray, "3 coefficient"]:
    """The shape of a train, moved by what its cell at rest differs from another one.

    That brings it nearly to the other cell's volume, which steps, however short, make up at once.
    """
    degree = math.isqrt(rest.shape[-1])
    before = resting_shape(start.train.cell, start.train.resolution.degree)
    moved = rest - change_degree(before, degree)
    return change_degree(start.coefficients, degree) + moved


def comes_close(train: Train, shape: Float[np.ndarray, "3 coefficient"]) -> bool:
    """Whether cells come so close to each other or the wall that their usual grids do not serve."""
    return clearance(shape, train.period, train.radius) < close_distance(train)


def _largest_move(system: SteadySystem, change: Float[np.ndarray, " unknown"]) -> float:
    """Largest displacement of a membrane point by a change of the unknowns, in r0."""
    values = np.asarray(system.operator.target_grid.values)
    shape = np.einsum("u,uik->ik", change, np.asarray(system.basis))
    moved = float(np.linalg.norm(values @ shape.T, axis=-1).max())
    return moved if math.isfinite(moved) else math.inf


def describe(
    system: SteadySystem,
    train: Train,
    unknowns: Float[np.ndarray, " unknown"],
    state: State,
    history: tuple[Iteration, ...],
    origin: str,
) -> Base:
    """The train with the given unknowns, its velocity's error not estimated."""
    shape = np.asarray(system.shape(jnp.asarray(unknowns)))
    return Base(
        train=train,
        coefficients=shape,
        cell_velocity=float(state.cell_velocity),
        gap=streamwise_gap(shape, train.period),
        largest_radius=largest_radius(shape),
        effective_viscosity=float(state.effective_viscosity),
        residual=float(state.residual),
        truncation_error=float(state.truncation_error),
        velocity_error=math.nan,
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
