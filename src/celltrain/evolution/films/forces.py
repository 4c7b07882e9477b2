"""Thin films in a train, and the repulsion's energy and forces in them.

    E = 1/2 sum over cells a, b of int phi(d_b(x)) dA_a + sum over cells a of int phi(d_w) dA_a,

with d_b(x) the distance of a point x of the membrane a from the membrane b (images and a cell's own
included, and for b = a the part of the membrane that faces x), d_w that from the wall, and dA_a the
area that the membrane has at rest: the layer is bound to it. A film between two membranes is
integrated from both sides, hence the half. Within a cell it is the film of its content between two
parts of its membrane, which would pass through each other otherwise.

The integrals are sums over the points of a grid. With w their areas, p = -phi', y the point of b
that is nearest to x, and n the direction from y to x, the force of x is w p n/2 and that of y the
opposite. It is the exact gradient of the sum, since moving y along b does not change the distance
to first order. So the forces between cells add up to no force and, acting along one line, to no
torque; without flow the energy of membranes and films together can only fall.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from celltrain.evolution.films.repulsion import Repulsion
from celltrain.harmonics import Shape, Shapes
from celltrain.membrane import resting_shape
from celltrain.parameters import Cell, Sizes
from celltrain.proximity.film_points import FilmGrid, film_grid
from celltrain.surroundings import Surroundings


@dataclass(frozen=True)
class Films:
    """What the repulsion does to given shapes.

    Attributes:
        gap: thickness of the thinnest film within the range, r0; infinite if there is none, not
            positive where membranes cross.
        energy: of all films, mu U r0^2.
        force: largest sum of the forces of films on a cell, without regard to their directions,
            mu U r0.
        forces: coefficients of the force per solid angle on the fluid, mu U r0; NaN where
            membranes cross.
    """

    gap: float
    energy: float
    force: float
    forces: Shapes


@dataclass(frozen=True, eq=False)
class FilmForces:
    """The repulsion in films of equal cells, whose membrane has the shape `at_rest`."""

    repulsion: Repulsion
    surroundings: Surroundings
    grid: FilmGrid
    at_rest: Shape

    @cached_property
    def areas(self) -> Float[np.ndarray, " point"]:
        """The membrane's at rest, at the grid's points."""
        (areas,) = self.grid.fine.surfaces(self.at_rest[None]).areas
        return self.grid.fine.weights * np.linalg.norm(areas, axis=-1)

    def __call__(self, shapes: Shapes) -> Films:
        """The films of all cells, whose mean points lie within one period."""
        none = Films(np.inf, 0.0, 0.0, np.zeros_like(shapes))
        within = self.repulsion.range
        if within == 0.0:
            return none
        around, surfaces = self.surroundings, self.grid.coarse.surfaces(shapes)
        found = self.grid.find(shapes, surfaces, within=within, period=around.period)
        walls = self.grid.at_wall(shapes, surfaces, within=within, wall=around.wall)
        if not len(found.distance) and not len(walls.distance):
            return none
        gap = float(min(found.distance.min(initial=np.inf), walls.distance.min(initial=np.inf)))
        if gap <= 0.0:
            return Films(gap, np.inf, np.inf, np.full_like(shapes, np.nan))
        weight, wall_weight = 0.5 * self.areas[found.node], self.areas[walls.node]
        size = weight * self.repulsion.pressure(found.distance)
        wall_size = wall_weight * self.repulsion.pressure(walls.distance)
        push, wall_push = size[:, None] * found.direction, wall_size[:, None] * walls.direction
        energy = np.sum(weight * self.repulsion.energy_density(found.distance))
        energy += np.sum(wall_weight * self.repulsion.energy_density(walls.distance))
        forces, totals = np.zeros_like(shapes), np.zeros(len(shapes))
        for cell in range(len(shapes)):
            mine, theirs, wall = found.cell == cell, found.other == cell, walls.cell == cell
            forces[cell] = (
                push[mine].T @ self.grid.fine.values[found.node[mine]]
                - push[theirs].T @ found.nearest[theirs]
                + wall_push[wall].T @ self.grid.fine.values[walls.node[wall]]
            )
            totals[cell] = size[mine].sum() + size[theirs].sum() + wall_size[wall].sum()
        return Films(gap, float(energy), float(totals.max()), forces)


def film_forces(
    cell: Cell, sizes: Sizes, surroundings: Surroundings, repulsion: Repulsion
) -> FilmForces:
    """The repulsion in the films of equal cells, whose shapes have the degree of `sizes`."""
    return FilmForces(
        repulsion=repulsion,
        surroundings=surroundings,
        grid=film_grid(sizes.degree),
        at_rest=resting_shape(cell, sizes.degree, sizes.grading),
    )
