"""What a simulation's file does not hold of its frames, computed again from their shapes."""

from collections.abc import Callable

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from celltrain.evolution.dynamics import train_dynamics
from celltrain.evolution.record.run import Run
from celltrain.evolution.wall_resolution import LARGEST, SMALLEST, followed
from celltrain.programs import Program
from celltrain.train import CellsOperator

#: Called with the number of frames done and that of all.
FrameProgress = Callable[[int, int], None]


def frame_rates(
    run: Run, *, progress: FrameProgress | None = None
) -> Float[np.ndarray, "frame cell 3 coefficient"]:
    """Rates of change of the frames' shapes relative to the tube, in U.

    Each takes as long as an evaluation of the velocity.
    """
    dynamics = train_dynamics(run.base, run.repulsion, wall_gap=LARGEST)
    rates = np.zeros_like(run.shapes)
    for number, shapes in enumerate(run.shapes):
        settled = dynamics.settle(shapes)
        # Between steps a frame may come closer than any step did.
        distance = max(dynamics.wall_distance(settled.shapes), SMALLEST)
        wall_gap = followed(dynamics.wall_gap, distance)
        if wall_gap != dynamics.wall_gap:
            dynamics = train_dynamics(run.base, run.repulsion, wall_gap=wall_gap, known=dynamics)
        rates[number] = dynamics.tube_rates(dynamics.rates(settled.shapes))
        if progress is not None:
            progress(number + 1, len(run.shapes))
    return rates


def pressure_drops(
    run: Run, *, progress: FrameProgress | None = None
) -> Float[np.ndarray, " frame"]:
    """Pressure drop of each frame relative to that of plasma alone at the same flow rate.

    At a viscosity ratio other than 1 it takes the rates of the frames, too (`frame_rates`).
    """
    dynamics = train_dynamics(run.base, run.repulsion, wall_gap=LARGEST)
    matched = dynamics.operator.viscosity_ratio is None
    rates = run.shapes if matched else frame_rates(run, progress=progress)
    found = []
    for shapes, motions in zip(run.shapes, rates, strict=True):
        settled = dynamics.settle(shapes).shapes
        films = dynamics.film_forces(settled).forces
        arguments = (jnp.asarray(each) for each in (settled, films, motions))
        found.append(float(_pressure_drop(dynamics.operator, *arguments)))
    return np.array(found)


@Program
def _pressure_drop(
    operator: CellsOperator, shapes: Array, film_forces: Array, motions: Array
) -> Array:
    forces = operator.forces(shapes) + film_forces
    return operator.effective_viscosity(shapes, forces, motions)
