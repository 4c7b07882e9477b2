"""The dynamics of a train in the frame of its steady flow, and what is done after each step.

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
from celltrain.evolution.state import Measures, Settled, State
from celltrain.harmonics import UNIT_DISPLACEMENT, Shapes, displaced_along, mean_points
from celltrain.membrane.geometry import surface_geometry
from celltrain.stability import paper_weights
from celltrain.steady import Base
from celltrain.train import TrainOperator, place_cells, train_operator

# Corrections of the volume after a step; Newton's method needs no more.
VOLUME_ITERATIONS = 2


class _Measured(eqx.Module):
    shapes: Float[Array, "cell 3 coefficient"]
    laps: Int[Array, " cell"]
    numbers: Float[Array, "5"]


class Dynamics(eqx.Module):
    """Rates of change of a train's shapes, relative to its steady flow.

    `base` are the shapes of the steady train, at rest in this frame; `weights` those of the paper's
    norm. Displacements and distances are in r0, rates in U. `wall_gap` is the smallest distance of
    a cell from the wall for which the wall is resolved, `film_forces` the repulsion in thin films.

    `steady_rates` are those of the steady train by this operator. They are its velocity along the
    tube but for what the rules of the operator leave (about 1e-6 U, part of it without symmetry),
    which the frame takes with it: otherwise it would move the train, and show as a disturbance.
    """

    operator: TrainOperator
    base: Float[Array, "cell 3 coefficient"]
    weights: Float[Array, " coefficient"]
    steady_rates: Float[np.ndarray, "cell 3 coefficient"]
    cell_velocity: float
    length: Float[Array, ""]
    volume: Float[Array, ""]
    film_forces: FilmForces = eqx.field(static=True)
    wall_gap: float = eqx.field(static=True)

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
        """Shapes where the cells have really gone, not put back by lengths of the train."""
        return displaced_along(shapes, float(self.length) * laps)

    def settle(self, shapes: Shapes) -> Settled:
        """Correct the volumes, put cells back into the train's window, and measure.

        `shapes` are continuous ones. The near sums count the images that cells within one length of
        the train can meet, so a cell whose mean point has left the window of that length is put
        back by whole lengths.
        """
        fixed = (self.operator, self.base, self.weights, self.length, self.volume)
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
        return State(
            **vars(settled), time=time, rates=self.rates(settled.shapes), wall_gap=self.wall_gap
        )

    def displacement(self, change: Shapes) -> float:
        """Largest displacement of a membrane's point by a change of the shapes, in r0."""
        moved = change @ np.asarray(self.operator.target_grid.values).T
        return float(np.sqrt(np.max(np.sum(moved**2, axis=1))))

    def wall_distance(self, shapes: Shapes) -> float:
        """Smallest distance of a membrane's point from the wall, in r0, negative beyond it."""
        across = shapes[:, :2] @ np.asarray(self.operator.target_grid.values).T
        return float(self.operator.tube.radius - np.sqrt(np.max(np.sum(across**2, axis=1))))

    def departure(self, shapes: Shapes) -> float:
        """Largest distance of a membrane's point from the steady train, of continuous shapes."""
        return self.displacement(shapes - np.asarray(self.base))


def train_dynamics(base: Base, repulsion: Repulsion, *, wall_gap: float) -> Dynamics:
    """The dynamics of the N cells of a train about a steady state."""
    train = base.train
    operator = train_operator(train, cells=train.cells, wall_gap=wall_gap)
    shapes = place_cells(base.coefficients, train, train.cells)
    return Dynamics(
        operator=operator,
        base=jnp.asarray(shapes),
        weights=jnp.asarray(paper_weights(train.degree)),
        steady_rates=_tube_rates(operator, shapes, np.zeros_like(shapes)),
        cell_velocity=base.cell_velocity,
        length=jnp.asarray(train.length),
        volume=operator.membrane.volume(jnp.asarray(base.coefficients)),
        film_forces=film_forces(train, repulsion),
        wall_gap=wall_gap,
    )


def _tube_rates(operator: TrainOperator, shapes: Shapes, forces: Shapes) -> Shapes:
    """Rates relative to the tube."""
    return np.asarray(_rates(operator, jnp.asarray(shapes), jnp.asarray(forces)))


@eqx.filter_jit
def _rates(operator: TrainOperator, shapes: Array, forces: Array) -> Array:
    return operator.rates(shapes, forces)


@eqx.filter_jit
def _settle(
    operator: TrainOperator,
    base: Float[Array, "cell 3 coefficient"],
    weights: Float[Array, " coefficient"],
    length: Float[Array, ""],
    volume: Float[Array, ""],
    shapes: Float[Array, "cell 3 coefficient"],
) -> _Measured:
    membrane = operator.membrane

    def corrected(shape: Array) -> Array:
        for _ in range(VOLUME_ITERATIONS):
            gradient = membrane.volume_gradient(shape)
            missing = volume - membrane.volume(shape)
            shape = shape + missing / jnp.sum(gradient**2) * gradient
        return shape

    def area(shape: Array) -> Array:
        element = surface_geometry(membrane.tables, shape).area
        return jnp.sum(element * membrane.inverse_sine * membrane.weights)

    settled = jax.vmap(corrected)(shapes)
    correction = (settled - shapes) @ operator.target_grid.values.T
    disturbance = settled - base
    # The window starts half a cell's period before the first cell of the steady train.
    start = mean_points(base[0])[2] - 0.5 * length / base.shape[0]
    laps = jnp.floor((mean_points(settled)[:, 2] - start) / length)
    numbers = jnp.stack(
        [
            jnp.sqrt(jnp.max(jnp.sum(correction**2, axis=1))),
            jnp.sqrt(jnp.sum(weights * disturbance**2)),
            jnp.sqrt(jnp.sum(disturbance**2)) / UNIT_DISPLACEMENT,
            jnp.sum(jax.vmap(membrane.energy)(settled)),
            jnp.sum(jax.vmap(area)(settled)),
        ]
    )
    wrapped = displaced_along(settled, -length * laps)
    return _Measured(wrapped, laps.astype(int), numbers)
