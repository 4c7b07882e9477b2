"""Stokes flow in a periodic round tube driven by force densities and a fixed flow rate.

    u(x) = (1/8 pi) sum_s G_tube(x, y_s) f_s + 2 (1 - r^2/R^2) (1 - Q0/(pi R^2)) e_z,

in units of U and mu. G_tube is the periodic Stokeslet (Ewald) minus the regular flow that cancels
it on the wall; Q0 is the flux of the first term, by reciprocity

    L Q0 = sum_s f_z [ (R^2 - r_s^2)/4 - pi R^4/(8 W^2) ],   W the width of the box,

whose second part, for a net force, belongs to the k = 0 mode that the Ewald sum leaves out. The
bracket 1 - Q0/(pi R^2) is the pressure drop relative to that of plasma alone, the effective
viscosity.
"""

import math

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Complex, Float, Int

from celltrain.flow.ewald import EwaldSplit, ewald_split, far_velocity_modes
from celltrain.flow.near import near_sum
from celltrain.flow.transform import (
    RingTransform,
    Transform,
    nonuniform_transform,
    ring_transform,
)
from celltrain.flow.wall import TubeWall, tube_wall


class PeriodicTube(eqx.Module):
    """Flow in one axial period of a tube.

    With `rings`, sources and targets must form rings about the axis (derivatives may leave them).
    A `quasi_periodic` one gives the flow of a wave along an infinite train from one period: images
    of the sources carry the factor exp(i q) per period, with q/period the `shift` of the wall's
    wave numbers, and velocities are complex. Unless q = 0 there is then no mean flow to hold.
    """

    split: EwaldSplit
    transform: Transform
    wall: TubeWall
    images: int = eqx.field(static=True)
    quasi_periodic: bool = eqx.field(static=True)

    @property
    def radius(self) -> float:
        """Radius of the tube, in r0."""
        return self.wall.radius

    def extra_flux(
        self,
        sources: Float[Array, "cell ring azimuth 3"],
        strengths: Float[Array, "cell ring azimuth 3"],
    ) -> Float[Array, ""]:
        """Q0/(pi R^2): mean velocity, in U, that the forces give without a pressure drop."""
        square = jnp.sum(sources[..., :2] ** 2, axis=-1)
        uniform = math.pi * self.radius**4 / (8.0 * self.split.width**2)
        weight = (self.radius**2 - square) / 4.0 - uniform
        flux = jnp.sum(strengths[..., 2] * weight) / self.wall.period
        return flux / (math.pi * self.radius**2)

    def velocity(
        self,
        targets: Float[Array, "group ring azimuth 3"],
        owners: Int[Array, " group"],
        sources: Float[Array, "cell source_ring source_azimuth 3"],
        strengths: Float[Array, "cell source_ring source_azimuth 3"],
    ) -> Float[Array, "group ring azimuth 3"] | Complex[Array, "group ring azimuth 3"]:
        """Velocity at points in the fluid or on cells, in U.

        **Arguments:** `owners`: cell on which each group of targets lies, -1 for points off the
        cells. The near kernel of a group's own cell is left out: see `OwnSurfaceRule`. `strengths`
        are forces, in mu U r0.
        """
        wall_points = self.wall.points()
        groups = targets.shape[:3]
        ring_shape = (-1, groups[2], 3)
        flat_targets = targets.reshape(ring_shape)
        flat_sources = sources.reshape(-1, *sources.shape[2:])
        force_modes = self.transform.analyse(flat_sources, strengths.reshape(flat_sources.shape))
        volume = self.split.width**2 * self.wall.period
        velocity_modes = jnp.stack(
            far_velocity_modes(
                (force_modes[0], force_modes[1], force_modes[2]),
                self.transform.wave_vectors(),
                volume,
                self.split.parameter,
            )
        )
        far, at_wall = self.transform.synthesise([flat_targets, wall_points], velocity_modes)
        loose = wall_points.reshape(1, -1, 3)
        at_wall = at_wall + self._near(loose, jnp.array([-1]), sources, strengths).reshape(
            wall_points.shape
        )
        near = self._near(targets.reshape(groups[0], -1, 3), owners, sources, strengths)
        regular = self.wall.regular_flow(at_wall.astype(complex))
        if isinstance(self.transform, RingTransform):
            reflected = self.wall.at_rings(flat_targets, regular)
        else:
            reflected = self.wall.at_points(flat_targets, regular)
        total = near.reshape(targets.shape) + (far - reflected).reshape(targets.shape)
        square = jnp.sum(targets[..., :2] ** 2, axis=-1)
        profile = 2.0 * (1.0 - square / self.radius**2)
        driven = profile * (1.0 - self.extra_flux(sources, strengths))
        if self.quasi_periodic:
            return total.at[..., 2].add(jnp.where(self.wall.shift == 0.0, driven, 0.0))
        return total.real.at[..., 2].add(driven)

    def _near(self, targets: Array, owners: Array, sources: Array, strengths: Array) -> Array:
        """Near sums over all images, [group, target, 3]."""
        cells = sources.shape[0]
        by_image = near_sum(
            targets,
            owners,
            sources.reshape(cells, -1, 3),
            strengths.reshape(cells, -1, 3),
            parameter=self.split.parameter,
            cutoff=self.split.cutoff,
            period=self.wall.period,
            images=self.images,
        ) / (8.0 * math.pi)
        if not self.quasi_periodic:
            return jnp.sum(by_image, axis=0)
        turn = self.wall.shift * self.wall.period
        phases = jnp.exp(1j * turn * jnp.arange(-self.images, self.images + 1))
        return jnp.einsum("p,pgtc->gtc", phases, by_image)


def periodic_tube(
    diameter: float,
    period: float,
    *,
    gap: float,
    extent: float,
    cutoff: float,
    tolerance: float,
    rings: bool,
    wave_number: float | None = None,
) -> PeriodicTube:
    """A tube of the given diameter and axial period (r0).

    **Arguments:**

    - `gap`: smallest distance of a cell from the wall for which the wall is resolved.
    - `extent`: how far sources and targets may reach axially beyond one period; with `cutoff` it
      fixes how many images the near sum visits.
    - `cutoff`, `tolerance`: range of the Ewald near kernel and relative truncation error.
    - `rings`: sources and targets form rings about the axis.
    - `wave_number`: q in radians per period, for a quasi-periodic flow (rings only).
    """
    split = ewald_split(diameter, cutoff, tolerance)
    shift = 0.0 if wave_number is None else wave_number / period
    transform: Transform
    if rings:
        transform = ring_transform(split, period, shift)
    elif wave_number is None:
        transform = nonuniform_transform(split, period, tolerance)
    else:
        raise ValueError("a quasi-periodic flow needs sources in rings")
    return PeriodicTube(
        split=split,
        transform=transform,
        wall=tube_wall(0.5 * diameter, period, gap=gap, tolerance=tolerance, shift=shift),
        images=math.floor((cutoff + extent + period) / period),
        quasi_periodic=wave_number is not None,
    )
