"""The one function that everything else uses: from the shapes of a train to their rates of change.

    shapes s --> force F = -dE/ds --> velocity u = K(s) F + u_flow --> ds/dt = v(s)

v(s) is the velocity on a target grid, expanded in the harmonics below the shape's degree, less the
small part that would change a cell's volume: the expansion's truncation lets a volume drift by
about 1e-6 r0^3 per r0/U, and with it steady trains would not exist to better than that.
"""

import math

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from celltrain.flow import (
    OwnSurfaceRule,
    PeriodicTube,
    Sources,
    SurroundingFlow,
    own_surface_rule,
)
from celltrain.flow.close import close_rule
from celltrain.flow.close_targets import CloseEvaluation
from celltrain.flow.sources import Surface
from celltrain.harmonics import Shapes, displaced_along, surface_points
from celltrain.harmonics.grid import SphereGrid, sphere_grid
from celltrain.harmonics.jax_shapes import JaxShapes
from celltrain.membrane import cell_material, place_cells, resting_shape
from celltrain.membrane.energy import Membrane, make_membrane
from celltrain.parameters import CaseError, Cell, Resolution, Train
from celltrain.runtime import check_jax, constant
from celltrain.surroundings import FlowRules, Surroundings, train_tube
from celltrain.train.coupling import Coupling
from celltrain.train.gmres import Iterations
from celltrain.train.interior import InteriorFlow, Outer, interior_flow
from celltrain.train.source_grid import SourceGrid, source_grid

# Largest axial distance of a membrane from its cell's centre for which images are counted.
HALF_LENGTH = 2.5
# Distance from a membrane, in steps of its source grid (unit sphere), below which the graded rule
# replaces that grid. Membranes are stretched by up to 1.4 against the unit sphere.
CLOSE_STEPS = 4.2
# Relative error of the ordinary rule there.
CLOSE_TOLERANCE = 1e-6
# Most iterations of GMRES; no case tried has taken half of them.
SOLVER_ITERATIONS = 40
# Residual of that equation relative to the tolerance of the sums in it.
SOLVER_TOLERANCE = 0.1


class CellsOperator(eqx.Module):
    """Rates of change of the shapes of equal cells, those of one period where there is one.

    Shapes may be any, and rates have forward derivatives. `viscosity_ratio` is absent if it is 1,
    and with it the double layer.
    """

    membrane: Membrane
    flow: SurroundingFlow
    own_rule: OwnSurfaceRule
    source_grid: SourceGrid
    coarse_grid: SourceGrid | None
    target_grid: SphereGrid
    viscosity_ratio: Float[Array, ""] | None
    coupling: Coupling | None
    solver_tolerance: Float[Array, ""]

    def rates(self, shapes: JaxShapes, added: JaxShapes | None = None) -> JaxShapes:
        """v(s) = ds/dt, in U; NaN if the flow inside the cells could not be solved for.

        **Arguments:** `added`: forces per solid angle beside those of the membranes, in mu U r0.
        """
        return self.solved_rates(shapes, added)[0]

    def solved_rates(
        self, shapes: JaxShapes, added: JaxShapes | None = None
    ) -> tuple[JaxShapes, Iterations | None]:
        """The rates, and how the equation for the flow inside the cells was solved, if there is."""
        free_rates = self.free_rates(shapes, added)
        if self.viscosity_ratio is None:
            return free_rates, None
        known = None
        if self.coupling is not None:
            known = (self.coupling, self.coupling.serves(shapes))
        rates, convergence = self.interior_flow(shapes).solve(
            self.outer_motion(shapes),
            self.viscosity_ratio,
            free_rates,
            coupling=known,
            tolerance=self.solver_tolerance,
            iterations=SOLVER_ITERATIONS,
        )
        solved = convergence.residual <= 10.0 * self.solver_tolerance
        return jnp.where(solved, rates, jnp.nan), convergence

    def free_rates(self, shapes: JaxShapes, added: JaxShapes | None = None) -> JaxShapes:
        """The rates that the same membranes would have at a viscosity ratio of 1."""
        forces = self.forces(shapes)
        velocity = self.surface_velocity(shapes, forces if added is None else forces + added)
        return self.conserve_volume(shapes, self.project(velocity))

    def interior_flow(self, shapes: JaxShapes) -> InteriorFlow:
        """The part of the flow that the cells' motion drives, if their viscosity differs."""
        longitudes = self.target_grid.phi
        kernels = self.own_rule.double_layer(self.targets(shapes), longitudes, shapes)
        gradients = jax.vmap(self.membrane.volume_gradient)(shapes)
        return interior_flow(kernels, self.target_grid.projection, shapes, gradients)

    def outer_motion(self, shapes: JaxShapes) -> Outer:
        """What cells' motions give through other cells, images and the wall, as rates."""
        targets, owners = self.targets(shapes), jnp.arange(shapes.shape[0])
        points = self.source_points(shapes)
        close = self.flow.close_targets(targets, owners, points, shapes=shapes)

        def outer(motions: JaxShapes) -> Array:
            sources = self.motion_sources(shapes, motions)
            velocity = self.flow.velocity(
                targets, owners, sources, close_targets=close, background=False
            )
            return self.project(velocity)

        return outer

    def surface_velocity(
        self, shapes: JaxShapes, forces: JaxShapes
    ) -> Float[Array, "cell ring azimuth 3"]:
        """Velocity at the points of the target grid, in U."""
        targets = self.targets(shapes)
        own = self.own_velocity(targets, shapes, forces)
        return own + self.outer_velocity(targets, shapes, forces)

    def forces(self, shapes: JaxShapes) -> JaxShapes:
        """Force of the membranes on the fluid per solid angle, in mu U r0."""
        return jax.vmap(self.membrane.force)(shapes)

    def targets(self, shapes: JaxShapes) -> Float[Array, "cell ring azimuth 3"]:
        """Points of the target grid on each cell."""
        grid = self.target_grid
        values = grid.values.reshape(grid.rings, grid.azimuths, -1)
        return jnp.einsum("rak,cik->crai", values, shapes)

    def source_points(self, shapes: JaxShapes) -> Float[Array, "cell ring azimuth 3"]:
        """Points of the source grid on each cell."""
        return self.source_grid.points(shapes)

    def sources(self, shapes: JaxShapes, forces: JaxShapes) -> Sources:
        """The source grids with the point forces there."""
        return self._sampled(Surface(shapes, forces=forces))

    def motion_sources(self, shapes: JaxShapes, motions: JaxShapes) -> Sources:
        """The source grids with the stresslets there of a double layer w = u."""
        return self._sampled(Surface(shapes, densities=motions))

    def _sampled(self, surface: Surface) -> Sources:
        coarse = None if self.coarse_grid is None else self.coarse_grid.samples(surface, None)
        return self.source_grid.samples(surface, coarse)

    def own_velocity(
        self, targets: Float[Array, "cell ring azimuth 3"], shapes: JaxShapes, forces: JaxShapes
    ) -> Float[Array, "cell ring azimuth 3"]:
        """Velocity on each cell by the near kernel of its own force."""
        return self.own_rule.velocity(targets, self.target_grid.phi, shapes, forces)

    def outer_velocity(
        self, targets: Float[Array, "cell ring azimuth 3"], shapes: JaxShapes, forces: JaxShapes
    ) -> Array:
        """All other parts of the velocity on the cells: other cells, images, wall, background."""
        owners = jnp.arange(shapes.shape[0])
        return self.flow.velocity(targets, owners, self.sources(shapes, forces))

    def velocity_at(
        self,
        points: Float[Array, "point 3"],
        shapes: JaxShapes,
        motions: JaxShapes | None = None,
    ) -> Float[Array, "point 3"]:
        """Velocity, in U, at points in the fluid or inside cells, up to the membranes.

        **Arguments:** `motions`: rates of the shapes, which count if they are not rigid and the
        viscosity ratio is not 1.
        """
        targets, off_cells = points[None, :, None], jnp.array([-1])
        sources = self.sources(shapes, self.forces(shapes))
        velocity = self.flow.velocity(targets, off_cells, sources)[0, :, 0]
        if motions is None or self.viscosity_ratio is None:
            return velocity

        def double_layer(motions: JaxShapes) -> Array:
            sources = self.motion_sources(shapes, motions)
            return self.flow.velocity(targets, off_cells, sources, background=False)[0, :, 0]

        velocity = velocity + (1.0 - self.viscosity_ratio) * double_layer(motions)
        # The double layer of a constant is its negative inside, and nothing outside.
        upward = displaced_along(jnp.zeros_like(shapes), 1.0)
        inside = double_layer(upward)[:, 2:] < -0.5
        return jnp.where(inside, velocity / self.viscosity_ratio, velocity)

    def project(self, velocity: Array) -> Array:
        """Harmonic coefficients [cell, 3, coefficient] of velocities on the target grid."""
        cells = velocity.shape[0]
        return jnp.einsum(
            "kp,cpi->cik", self.target_grid.projection, velocity.reshape(cells, -1, 3)
        )

    def conserve_volume(self, shapes: JaxShapes, rates: Array) -> Array:
        """Rates without their component along the gradient of each cell's volume."""
        gradient = jax.vmap(self.membrane.volume_gradient)(shapes)
        along = jnp.sum(gradient * rates, axis=(1, 2)) / jnp.sum(gradient**2, axis=(1, 2))
        return rates - along[:, None, None] * gradient

    def effective_viscosity(
        self, shapes: JaxShapes, forces: JaxShapes, motions: JaxShapes | None = None
    ) -> Float[Array, ""]:
        """Pressure drop relative to that of plasma alone at the same flow rate.

        **Arguments:** `motions`: rates of the shapes, which count if they are not rigid and the
        viscosity ratio is not 1.

        **Raises:** `CaseError` for cells that are in no tube.
        """
        tube = self.flow
        if not isinstance(tube, PeriodicTube):
            raise CaseError("an effective viscosity is that of a tube: these cells are in none")
        pressure = 1.0 - tube.extra_flux(self.sources(shapes, forces))
        if motions is None or self.viscosity_ratio is None:
            return pressure
        flux = tube.extra_flux(self.motion_sources(shapes, motions))
        return pressure - (1.0 - self.viscosity_ratio) * flux


def cells_membrane(cell: Cell, resolution: Resolution) -> Membrane:
    """The membrane that cells have."""
    sizes = resolution.sizes
    shape = resting_shape(cell, sizes.degree, sizes.grading)
    return make_membrane(*cell_material(cell), shape, energy_order=sizes.energy_order)


def train_membrane(train: Train) -> Membrane:
    """The membrane that a train's cells have."""
    return cells_membrane(train.cell, train.resolution)


def resting_shapes(train: Train, cells: int) -> Shapes:
    """Resting cells on the axis, one period apart, the first at z = 0."""
    sizes = train.sizes
    return place_cells(resting_shape(train.cell, sizes.degree, sizes.grading), train, cells)


def close_distance(resolution: Resolution) -> float:
    """Distance from a membrane, in r0, below which its ordinary source grid does not serve."""
    return CLOSE_STEPS * math.pi / resolution.sizes.source_order


def train_operator(
    train: Train,
    *,
    cells: int = 1,
    close: bool = True,
    wall_gap: float | None = None,
    coupling: Coupling | None = None,
) -> CellsOperator:
    """The operator for `cells` cells of a train in a period of their own.

    **Arguments:** `close`, `wall_gap`, `coupling`: as for `cells_operator`.

    **Raises:** `UnsuitableSetting` where JAX is set so that it cannot compute it.
    """
    return cells_operator(
        train.cell,
        train.resolution,
        train_tube(train, cells),
        viscosity_ratio=train.flow.viscosity_ratio,
        close=close,
        wall_gap=wall_gap,
        coupling=coupling,
    )


def cells_operator(
    cell: Cell,
    resolution: Resolution,
    surroundings: Surroundings,
    *,
    viscosity_ratio: float = 1.0,
    close: bool = True,
    wall_gap: float | None = None,
    coupling: Coupling | None = None,
) -> CellsOperator:
    """The operator for equal cells, as many as its shapes say, in any surroundings.

    **Arguments:**

    - `viscosity_ratio`: viscosity inside the cells over that outside.
    - `close`: whether cells may come closer to each other or to the wall than `close_distance`.
    - `wall_gap`: smallest distance of a cell from the wall, in r0, for which the wall is resolved.
      If cells are nearer, errors grow, and rates may be NaN. By default the wall is resolved for
      the distance of a resting cell about the origin, and nearer cells have errors only.
    - `coupling`: what the cells of a steady train give each other, which lets the flow inside cells
      be found in fewer iterations near that train.

    **Raises:** `UnsuitableSetting` where JAX is set so that it cannot compute it; `CaseError` for a
    resolution without a degree.
    """
    check_jax()
    sizes = resolution.sizes
    membrane = cells_membrane(cell, resolution)
    target_grid = sphere_grid(sizes.degree, sizes.target_order)
    order = sizes.source_order
    halved = order % 2 == 0 and order // 2 >= sizes.degree
    near = close_distance(resolution)
    near_wall = wall_gap is None or wall_gap < near
    if wall_gap is None:
        resting = surface_points(np.asarray(membrane.reference_shape), target_grid.values)
        wall_gap = surroundings.wall_distance(np.asarray(resting))

    def close_evaluation(parameter: float) -> CloseEvaluation:
        rule = close_rule(sizes.degree, parameter=parameter, farthest=near)
        angles = np.stack(sphere_grid(sizes.degree, order).points(), axis=-1)
        return CloseEvaluation(rule, constant(angles), near)

    # Errors of the ordinary rules fall exponentially with the distance.
    farther = max(1.0, math.log(resolution.tolerance) / math.log(CLOSE_TOLERANCE))
    flow = surroundings.flow(
        FlowRules(
            near_cutoff=resolution.near_cutoff,
            tolerance=resolution.tolerance,
            wall_gap=wall_gap,
            extent=HALF_LENGTH,
            close=close_evaluation if close else None,
            near_wall=near_wall,
            coarse_beyond=2.0 * near * farther,
        )
    )
    return CellsOperator(
        membrane=membrane,
        flow=flow,
        own_rule=own_surface_rule(
            sizes.degree,
            np.asarray(target_grid.theta),
            radial=sizes.polar_radial,
            azimuthal=sizes.polar_azimuthal,
            parameter=flow.near_parameter,
        ),
        source_grid=source_grid(sizes.degree, order),
        coarse_grid=source_grid(sizes.degree, order // 2) if halved else None,
        target_grid=target_grid,
        viscosity_ratio=None if viscosity_ratio == 1.0 else constant(float(viscosity_ratio)),
        coupling=coupling,
        solver_tolerance=constant(SOLVER_TOLERANCE * resolution.tolerance),
    )
