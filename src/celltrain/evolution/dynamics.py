"""The dynamics of cells, of a train in the frame of its steady flow, and what follows each step.

Shapes are those of all N cells, on the host: a few tens of kilobytes, so that integrators may
combine them there and only one program, the rates, is compiled for all of them.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from celltrain.evolution.films.forces import FilmForces, Films, film_forces
from celltrain.evolution.films.repulsion import Repulsion
from celltrain.evolution.linear_part import LinearPart
from celltrain.evolution.state import Measures, Settled, State
from celltrain.harmonics import (
    UNIT_DISPLACEMENT,
    Shapes,
    displaced_along,
    mean_points,
    surface_points,
)
from celltrain.laws import MomentBending
from celltrain.membrane import place_cells
from celltrain.membrane.geometry import surface_geometry
from celltrain.programs import Program
from celltrain.proximity.overlaps import Overlap, overlaps
from celltrain.runtime import constant
from celltrain.stability import paper_weights
from celltrain.steady import Base
from celltrain.surroundings import Surroundings, train_tube
from celltrain.train import CellsOperator, train_coupling, train_operator

# Corrections of the volume after a step; Newton's method needs no more.
VOLUME_ITERATIONS = 2


class _Measured(eqx.Module):
    shapes: Float[Array, "cell 3 coefficient"]
    laps: Int[Array, " cell"]
    numbers: Float[Array, "5"]


class Dynamics(eqx.Module):
    """Rates of change of cells' shapes, of a train relative to its steady flow.

    `base` are the shapes from which departures are measured, those of the steady train, at rest in
    this frame; `weights` those of the paper's norm. Displacements and distances are in r0, rates in
    U. `wall_gap` is the smallest distance of a cell from the wall for which the wall is resolved,
    `film_forces` the repulsion in thin films.

    `steady_rates` are those of the steady train by this operator. They are its velocity along the
    tube but for what the rules of the operator leave (about 1e-6 U, part of it without symmetry),
    which the frame takes with it: otherwise it would move the train, and show as a disturbance.
    Cells that are no train have none, and `cell_velocity` 0.
    """

    operator: CellsOperator
    base: Float[Array, "cell 3 coefficient"]
    weights: Float[Array, " coefficient"]
    steady_rates: Float[np.ndarray, "cell 3 coefficient"]
    cell_velocity: float
    volumes: Float[Array, " cell"]
    surroundings: Surroundings = eqx.field(static=True)
    film_forces: FilmForces = eqx.field(static=True)
    wall_gap: float = eqx.field(static=True)
    linear_part: LinearPart | None = eqx.field(static=True, default=None)

    def rates(self, shapes: Shapes) -> Shapes:
        """ds/dt in the frame of the steady train, in U.

        NaN for shapes that are, and where the repulsion finds membranes crossing.
        """
        if not np.isfinite(shapes).all():
            return np.full_like(shapes, np.nan)
        films = self.film_forces(shapes)
        if films.gap <= 0.0:
            return films.forces
        return self.forced_rates(shapes, films.forces)

    def forced_rates(self, shapes: Shapes, forces: Shapes) -> Shapes:
        """The rates with given forces per solid angle (mu U r0) beside those of the membranes."""
        return _tube_rates(self.operator, shapes, forces) - self.steady_rates

    def tube_rates(self, rates: Shapes) -> Shapes:
        """The same rates relative to the tube."""
        return displaced_along(rates, self.cell_velocity)

    def continuous(self, shapes: Shapes, laps: Int[np.ndarray, " cell"]) -> Shapes:
        """Shapes where the cells have really gone, not put back by periods."""
        if not self.surroundings.recurs:
            return shapes
        return displaced_along(shapes, self.surroundings.period * laps)

    def settle(self, shapes: Shapes) -> Settled:
        """Correct the volumes, put cells back into the window of one period, and measure.

        `shapes` are continuous ones. The near sums count the images that cells within one period
        can meet, so a cell whose mean point has left the window of that length is put back by whole
        periods.
        """
        period = jnp.asarray(self.surroundings.period) if self.surroundings.recurs else None
        fixed = (self.operator, self.base, self.weights, period, self.volumes)
        found = _settle(*fixed, jnp.asarray(shapes))
        settled = np.asarray(found.shapes)
        finite = bool(np.isfinite(settled).all())
        films = self.film_forces(settled) if finite else Films(np.nan, np.nan, np.nan, settled)
        correction, eps, eps_x, energy, area = (float(each) for each in np.asarray(found.numbers))
        measures = Measures(
            eps=eps,
            eps_x=eps_x,
            energy=energy,
            area=area,
            volume_correction=correction,
            gap=films.gap,
            film_energy=films.energy,
            film_force=films.force,
        )
        return Settled(settled, np.asarray(found.laps), measures)

    def state(self, time: float, shapes: Shapes) -> State:
        """The state of a train with the given (continuous) shapes at a time.

        Its rates are NaN where those of `rates` are.
        """
        settled = self.settle(shapes)
        rates = self.rates(settled.shapes)
        return State(**vars(settled), time=time, rates=rates, wall_gap=self.wall_gap)

    def displacement(self, change: Shapes) -> float:
        """Largest displacement of a membrane's point by a change of the shapes, in r0."""
        moved = change @ np.asarray(self.operator.target_grid.values).T
        return float(np.sqrt(np.max(np.sum(moved**2, axis=1))))

    def wall_distance(self, shapes: Shapes) -> float:
        """Smallest distance of a membrane's point from the wall, in r0, negative beyond it."""
        points = surface_points(shapes, np.asarray(self.operator.target_grid.values))
        return self.surroundings.wall_distance(points)

    def overlaps(self, shapes: Shapes) -> tuple[Overlap, ...]:
        """Cells that overlap each other, or reach into the wall."""
        around = self.surroundings
        return overlaps(shapes, period=around.period, wall=around.wall)

    def departure(self, shapes: Shapes) -> float:
        """Largest distance of a membrane's point from the steady train, of continuous shapes."""
        return self.displacement(shapes - np.asarray(self.base))


def train_dynamics(
    base: Base,
    repulsion: Repulsion,
    *,
    wall_gap: float,
    known: Dynamics | None = None,
) -> Dynamics:
    """The dynamics of the N cells of a train about a steady state.

    **Arguments:** `known`: dynamics of the same train for another gap, whose parts serve again.
    """
    train = base.train
    tube = train_tube(train)
    coupling = None
    if train.flow.viscosity_ratio != 1.0:
        coupling = train_coupling(base) if known is None else known.operator.coupling
    operator = train_operator(train, cells=train.cells, wall_gap=wall_gap, coupling=coupling)
    shapes = place_cells(base.coefficients, train, train.cells)
    return Dynamics(
        operator=operator,
        base=constant(shapes),
        weights=constant(paper_weights(train.degree)),
        steady_rates=_tube_rates(operator, shapes, np.zeros_like(shapes)),
        cell_velocity=base.cell_velocity,
        volumes=cell_volumes(operator, jnp.asarray(shapes)),
        surroundings=tube,
        film_forces=film_forces(train.cell, train.sizes, tube, repulsion),
        wall_gap=wall_gap,
        linear_part=LinearPart(base) if known is None else known.linear_part,
    )


@Program
def cell_volumes(
    operator: CellsOperator, shapes: Float[Array, "cell 3 coefficient"]
) -> Float[Array, " cell"]:
    """Volume of each cell, r0^3."""
    return jax.vmap(operator.membrane.volume)(shapes)


def _tube_rates(operator: CellsOperator, shapes: Shapes, forces: Shapes) -> Shapes:
    """Rates relative to the tube."""
    return np.asarray(_rates(operator, jnp.asarray(shapes), jnp.asarray(forces)))


@Program
def _rates(operator: CellsOperator, shapes: Array, forces: Array) -> Array:
    return operator.rates(shapes, forces)


@Program
def _settle(
    operator: CellsOperator,
    base: Float[Array, "cell 3 coefficient"],
    weights: Float[Array, " coefficient"],
    period: Float[Array, ""] | None,
    volumes: Float[Array, " cell"],
    shapes: Float[Array, "cell 3 coefficient"],
) -> _Measured:
    membrane = operator.membrane

    def corrected(shape: Array, volume: Array) -> Array:
        for _ in range(VOLUME_ITERATIONS):
            gradient = membrane.volume_gradient(shape)
            missing = volume - membrane.volume(shape)
            shape = shape + missing / jnp.sum(gradient**2) * gradient
        return shape

    def energy(shape: Array) -> Array:
        # Bending moments have none.
        moments = isinstance(membrane.bending, MomentBending)
        return jnp.array(jnp.nan) if moments else membrane.energy(shape)

    def area(shape: Array) -> Array:
        element = surface_geometry(membrane.tables, shape).area
        return jnp.sum(element * membrane.inverse_sine * membrane.weights)

    settled = jax.vmap(corrected)(shapes, volumes)
    correction = (settled - shapes) @ operator.target_grid.values.T
    disturbance = settled - base
    laps = jnp.zeros(base.shape[0])
    wrapped = settled
    if period is not None:
        # The window starts half a cell's share before the first cell.
        start = mean_points(base[0])[2] - 0.5 * period / base.shape[0]
        laps = jnp.floor((mean_points(settled)[:, 2] - start) / period)
        wrapped = displaced_along(settled, -period * laps)
    numbers = jnp.stack(
        [
            jnp.sqrt(jnp.max(jnp.sum(correction**2, axis=1))),
            jnp.sqrt(jnp.sum(weights * disturbance**2)),
            jnp.sqrt(jnp.sum(disturbance**2)) / UNIT_DISPLACEMENT,
            jnp.sum(jax.vmap(energy)(settled)),
            jnp.sum(jax.vmap(area)(settled)),
        ]
    )
    return _Measured(wrapped, laps.astype(int), numbers)
