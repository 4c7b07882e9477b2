"""Stokes flow in a periodic round tube driven by surface densities and a fixed flow rate.

    u(x) = (1/8 pi) sum_s [ G_tube(x, y_s) f_s + T_tube(x, y_s) D_s/2 ]
           + 2 (1 - r^2/R^2) (1 - Q0/(pi R^2)) e_z,

in units of U and mu. G_tube is the periodic Stokeslet (Ewald) minus the regular flow that cancels
it on the wall, T_tube its stress; D = w n + n w (see `Sources`). Q0 is the flux of the first term,
by reciprocity

    L Q0 = sum_s f_z [ (R^2 - r_s^2)/4 - pi R^4/(8 W^2) ] - (D_zx x_s + D_zy y_s)/2 + tr(D) z_s/2,

W the width of the box. The constant, for a net force, belongs to the k = 0 mode that the Ewald sum
leaves out; the last term is the flux of the sources w.n that a double layer has on its surface. The
bracket 1 - Q0/(pi R^2) is the pressure drop relative to that of plasma alone, the effective
viscosity.
"""

import math
from collections.abc import Callable

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from celltrain.flow.cell_sums import CELL_SHARE, CellSums
from celltrain.flow.close_targets import CloseEvaluation
from celltrain.flow.ewald import ewald_split, far_velocity_modes
from celltrain.flow.sources import Sources
from celltrain.flow.surrounding_flow import CloseTargetSets, SurroundingFlow
from celltrain.flow.transform import Transform, transform
from celltrain.flow.wall import TubeWall, tube_wall
from celltrain.flow.wall_synthesis import WallSynthesis, wall_synthesis
from celltrain.harmonics.jax_shapes import JaxShapes
from celltrain.runtime import constant

# Close pairs listed for each point of the wall, on average, where cells may be that close to it.
WALL_SHARE = 0.5


class PeriodicTube(SurroundingFlow):
    """Flow in one axial period of a tube; velocities have forward derivatives.

    `wall_share`: close pairs listed for each point of the wall, on average.
    """

    near: CellSums
    transform: Transform
    wall: TubeWall
    wall_synthesis: WallSynthesis
    wall_share: float = eqx.field(static=True)

    @property
    def near_parameter(self) -> float:
        """See `SurroundingFlow`."""
        return self.near.parameter

    @property
    def radius(self) -> Float[Array, ""]:
        """Radius of the tube, in r0."""
        return self.wall.radius

    def extra_flux(self, sources: Sources) -> Float[Array, ""]:
        """Q0/(pi R^2): mean velocity, in U, that the sources give without a pressure drop."""
        x, y, z = (sources.points[..., i] for i in range(3))
        flux = jnp.zeros(())
        if sources.forces is not None:
            uniform = math.pi * self.radius**4 / (8.0 * self.transform.box[0] ** 2)
            weight = (self.radius**2 - x**2 - y**2) / 4.0 - uniform
            flux = flux + jnp.sum(sources.forces[..., 2] * weight)
        if sources.stresslets is not None:
            xx, _, xz, yy, yz, zz = (sources.stresslets[..., i] for i in range(6))
            # Each cell's sources add up to nothing: heights from its centre lose no digits.
            height = z - jnp.mean(z, axis=(1, 2), keepdims=True)
            flux = flux + 0.5 * jnp.sum((xx + yy + zz) * height - xz * x - yz * y)
        return flux / (self.wall.period * math.pi * self.radius**2)

    def velocity(
        self,
        targets: Float[Array, "group ring azimuth 3"],
        owners: Int[Array, " group"],
        sources: Sources,
        *,
        close_targets: CloseTargetSets | None = None,
        background: bool = True,
    ) -> Float[Array, "group ring azimuth 3"]:
        """See `SurroundingFlow`; without the background the mean velocity is 0 instead of 1."""
        if close_targets is None and sources.surface is not None:
            close_targets = self.close_targets(targets, owners, sources.points)
        by_cells, by_wall = (None, None) if close_targets is None else close_targets
        loose = _numbers(targets).reshape(-1, 3)
        modes = self._far_modes(sources)
        far = self.transform.synthesise(loose, modes)
        strips, places = self.wall.strips()
        off_cells = jnp.full(len(strips), -1)
        wall_strips = self.wall.points().reshape(-1, 3)[strips]
        wall_near = self.near.velocity(wall_strips, off_cells, sources, by_wall)
        at_wall = self.wall_synthesis.fields(modes)
        at_wall = at_wall + wall_near.reshape(-1, 3)[places].reshape(at_wall.shape)
        groups = targets.reshape(targets.shape[0], -1, 3)
        near = self.near.velocity(groups, owners, sources, by_cells)
        reflected = self.wall.velocity(loose, self.wall.regular_flow(at_wall))
        total = near.reshape(targets.shape) + (far - reflected).reshape(targets.shape)
        total = jnp.where(jnp.isfinite(targets), total, jnp.nan)
        square = jnp.sum(targets[..., :2] ** 2, axis=-1)
        profile = 2.0 * (1.0 - square / self.radius**2)
        return total.at[..., 2].add(profile * (float(background) - self.extra_flux(sources)))

    def _far_modes(self, sources: Sources) -> Array:
        """Far velocity [3, *mode]."""
        points = _numbers(sources.points).reshape(-1, 3)
        parts = [each for each in (sources.forces, sources.stresslets) if each is not None]
        strengths = jnp.concatenate(parts, axis=-1).reshape(len(points), -1)
        modes = tuple(self.transform.analyse(points, strengths))
        return jnp.stack(
            far_velocity_modes(
                modes[:3] if sources.forces is not None else None,
                modes[-6:] if sources.stresslets is not None else None,
                self.transform.wave_vectors(),
                jnp.prod(self.transform.box),
                self.near.parameter,
            )
        )

    def close_targets(
        self,
        targets: Float[Array, "group ring azimuth 3"],
        owners: Int[Array, " group"],
        points: Float[Array, "cell source_ring source_azimuth 3"],
        *,
        shapes: JaxShapes | None = None,
    ) -> CloseTargetSets | None:
        """See `SurroundingFlow`; those among the targets, and those among the wall's points."""
        strips, _ = self.wall.strips()
        wall = self.wall.points().reshape(-1, 3)[strips]
        off_cells = jnp.full(len(strips), -1)
        groups = targets.reshape(targets.shape[0], -1, 3)
        by_cells = self.near.close_targets(groups, owners, points, CELL_SHARE, shapes=shapes)
        by_wall = self.near.close_targets(wall, off_cells, points, self.wall_share, shapes=shapes)
        return None if by_cells is None or by_wall is None else (by_cells, by_wall)


def _numbers(points: Array) -> Array:
    """Points with 0 for what is no number, which would spread to all others."""
    return jnp.where(jnp.isfinite(points), points, 0.0)


def periodic_tube(
    diameter: float,
    period: float,
    *,
    wall_gap: float,
    extent: float,
    cutoff: float,
    tolerance: float,
    close: Callable[[float], CloseEvaluation] | None = None,
    near_wall: bool = True,
    coarse_beyond: float = math.inf,
) -> PeriodicTube:
    """A tube of the given diameter and axial period (r0).

    **Arguments:**

    - `wall_gap`: smallest distance of a cell from the wall for which the wall is resolved.
    - `extent`: how far sources and targets may reach axially beyond one period; with `cutoff` it
      fixes how many images the near sum visits.
    - `cutoff`, `tolerance`: range of the Ewald near kernel and relative truncation error.
    - `close`: makes what serves targets close to a cell, from the parameter of the near kernel.
    - `near_wall`: whether cells may be that close to the wall. If not, a few such pairs of a cell
      and a point of the wall are served, and with more of them velocities are NaN.
    - `coarse_beyond`: distance from a cell at which its coarse samples serve.
    """
    split = ewald_split(cutoff, tolerance)
    # Wider than the tube by the near kernel's range, which so never reaches an image across.
    box = transform(split, diameter + cutoff, period, tolerance)
    wall = tube_wall(0.5 * diameter, period, wall_gap=wall_gap, tolerance=tolerance)
    return PeriodicTube(
        near=CellSums(
            parameter=split.parameter,
            cutoff=split.cutoff,
            period=constant(float(period)),
            images=math.floor((cutoff + extent + period) / period),
            close=None if close is None else close(split.parameter),
            coarse_beyond=coarse_beyond,
        ),
        transform=box,
        wall=wall,
        wall_synthesis=wall_synthesis(box, wall),
        wall_share=WALL_SHARE if near_wall else 0.0,
    )
