"""Equal cells of any shapes in any surroundings, followed in time: no steady train is needed."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from celltrain.evolution.checks import check_positive
from celltrain.evolution.dynamics import Dynamics, cell_volumes
from celltrain.evolution.ending import StepFailed
from celltrain.evolution.films.forces import film_forces
from celltrain.evolution.films.repulsion import Repulsion
from celltrain.evolution.methods import Integrator, Method, RungeKuttaChebyshev, Step
from celltrain.evolution.record.frames import due_times, shapes_within
from celltrain.evolution.state import State
from celltrain.evolution.wall_resolution import LARGEST, followed
from celltrain.harmonics import Shapes, displaced
from celltrain.membrane import resting_shape
from celltrain.parameters import CaseError, Cell, Resolution
from celltrain.runtime import constant
from celltrain.stability import paper_weights
from celltrain.surroundings import Surroundings
from celltrain.train import CellsOperator, cells_operator


@dataclass(frozen=True)
class Snapshot:
    """Shapes at a time (r0/U): coefficients of all cells where they have really gone, in r0."""

    time: float
    shapes: Shapes


@dataclass(frozen=True)
class CellsInFlow:
    """Equal cells and what is around them; lengths in r0, velocities in U, viscosities in mu.

    `viscosity_ratio` is the viscosity inside the cells over that outside; the resolution needs a
    degree.
    """

    cell: Cell
    surroundings: Surroundings
    resolution: Resolution
    viscosity_ratio: float = 1.0
    repulsion: Repulsion = field(default_factory=Repulsion)

    def __post_init__(self) -> None:
        check_positive("viscosity_ratio", self.viscosity_ratio)

    def resting(self, places: Sequence[Sequence[float]]) -> Shapes:
        """Cells at rest with their middles at places (r0).

        **Raises:** `CaseError` for a resolution without a degree.
        """
        sizes = self.resolution.sizes
        shape = resting_shape(self.cell, sizes.degree, sizes.grading)
        middles = np.asarray(places, dtype=float).reshape(-1, 3)
        return displaced(np.repeat(shape[None], len(middles), axis=0), middles)

    def operator(self, *, close: bool = True, wall_gap: float | None = None) -> CellsOperator:
        """From shapes to their rates of change; arguments as for `cells_operator`."""
        return cells_operator(
            self.cell,
            self.resolution,
            self.surroundings,
            viscosity_ratio=self.viscosity_ratio,
            close=close,
            wall_gap=wall_gap,
        )

    def dynamics(self, shapes: Shapes, *, wall_gap: float = LARGEST) -> Dynamics:
        """What methods march, from these shapes, whose volumes are kept.

        **Raises:** `CaseError` for shapes of another degree than the resolution's, or not finite.
        """
        degree = self.resolution.sizes.degree
        if shapes.ndim != 3 or shapes.shape[1:] != (3, degree**2):
            raise CaseError(
                f"shapes {shapes.shape} are not allowed: at degree {degree} they are"
                f" [cell, 3, {degree**2}]"
            )
        if not np.isfinite(shapes).all():
            raise CaseError("shapes with NaN or infinite coefficients are not allowed")
        around = self.surroundings
        alone = len(shapes) == 1 and around.empty
        operator = self.operator(close=not alone, wall_gap=wall_gap)
        return Dynamics(
            operator=operator,
            base=constant(shapes),
            weights=constant(paper_weights(degree)),
            steady_rates=np.zeros_like(shapes),
            cell_velocity=0.0,
            volumes=cell_volumes(operator, jnp.asarray(shapes)),
            surroundings=around,
            film_forces=film_forces(self.cell, self.resolution.sizes, around, self.repulsion),
            wall_gap=wall_gap,
        )


def follow(
    cells: CellsInFlow,
    shapes: Float[np.ndarray, "cell 3 coefficient"],
    *,
    until: float,
    every: float = 1.0,
    integrator: Method | None = None,
) -> Iterator[Snapshot]:
    """The shapes at time 0, at multiples of `every`, and at `until` (r0/U), as they are reached.

    **Arguments:** `integrator`: `RungeKuttaChebyshev()` unless given. Snapshots lie within its
    steps and do not change them.

    **Raises:** `CaseError` for settings that are not allowed, and for cells that overlap from the
    beginning; `StepFailed` if no step can be taken: cells overlap, have no finite velocity, or are
    too close to the wall.
    """
    check_positive("until", until)
    check_positive("every", every)
    method: Integrator[Any] = RungeKuttaChebyshev() if integrator is None else integrator
    if method.needs_train:
        raise CaseError(
            f"integrator = {type(method).__name__} is not allowed: it marches trains; allowed:"
            " RungeKuttaChebyshev, ForwardEuler"
        )
    dynamics = cells.dynamics(np.asarray(shapes, dtype=float))
    met = dynamics.overlaps(np.asarray(dynamics.base))
    if met:
        raise CaseError(f"these shapes are not allowed: {met[0]}")
    dynamics = _resolving(cells, dynamics, shapes)
    return _steps(cells, dynamics, method, until, every)


def _steps(
    cells: CellsInFlow, dynamics: Dynamics, method: Integrator[Any], until: float, every: float
) -> Iterator[Snapshot]:
    state = dynamics.state(0.0, np.asarray(dynamics.base))
    memory, last = method.begin(state), 0.0
    yield Snapshot(0.0, dynamics.continuous(state.shapes, state.laps))
    while last < until:
        dynamics = _resolving(cells, dynamics, state.shapes)
        step = _apart(method, dynamics, state, memory)
        for time in due_times(last, step.state.time, every=every, until=until):
            yield Snapshot(time, shapes_within(dynamics, state, step, time))
            last = time
        state, memory = step.state, step.memory


def _apart(method: Integrator[Any], dynamics: Dynamics, state: State, memory: Any) -> Step[Any]:
    """A step after which no cells overlap, by shorter ones if it takes that."""
    while True:
        step = method.advance(dynamics, state, memory)
        met = dynamics.overlaps(step.state.shapes)
        if not met:
            return step
        shorter = method.shortened(memory, step.manner.size)
        if shorter is None:
            raise StepFailed("overlap", f"at t = {step.state.time:.6g} r0/U {met[0]}")
        memory = shorter


def _resolving(cells: CellsInFlow, dynamics: Dynamics, shapes: Shapes) -> Dynamics:
    """The dynamics, with the wall resolved for where the cells are."""
    distance = dynamics.wall_distance(shapes)
    wall_gap = dynamics.wall_gap
    if math.isfinite(distance):
        wall_gap = followed(wall_gap, distance)
    if wall_gap == dynamics.wall_gap:
        return dynamics
    return cells.dynamics(np.asarray(dynamics.base), wall_gap=wall_gap)
