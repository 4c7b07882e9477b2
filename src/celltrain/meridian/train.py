"""A train of equal axisymmetric cells: its velocity, and the exact dynamics of disturbances.

For the shape s of the cells the rates of change are the projection of the velocity u on the
harmonics below the degree, less what would change the volume, v = P u - n (n.P u)/(n.n), n = dV/ds.
About it, with the force's change dF = -H_m dx of the members of azimuthal number m,

    A_m(q) = P [ U_G(-H_m) - U_D + dx . grad u ] - changes of the volume's direction,

U_G the velocities of changed forces, U_D those of forces that move along with their surface, and
grad u the gradient of the steady flow in which the targets move (the integral equations are in
Pozrikidis 1992). On the cell's own surface the last
two are weakly singular together: what the own kernel makes of constants is part of grad u.
For m = 0

    A <- A - n n^T A/nn - ((n.u)/nn) V'' - n (u^T V'')/nn + 2 (n.u)/nn^2 n (n^T V''),

and for m > 0 only the term with V'' is left, V'' the second derivative of the volume.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Complex, Float

from celltrain.harmonics import Profile
from celltrain.membrane.axisymmetric import AxisymmetricMembrane
from celltrain.meridian import flow_rate
from celltrain.meridian.grids import Amplitudes, HalfCircle, Meridian, MeridianGrid, meridian_grid
from celltrain.meridian.images import ImageMoments, force_image
from celltrain.meridian.moments import SINGLE, SLOPE, MemberMatrix, member_matrix
from celltrain.meridian.own_surface import OwnMoments, force_moments, own_rule
from celltrain.meridian.rules import Rules
from celltrain.meridian.tail import Tail
from celltrain.meridian.wall import WallFlow, WallWaves

#: The axisymmetric disturbances that are alike in all cells are m = 0 at this phase.
ALIKE = 0.0
#: Smallest phase q > 0, radians, that the tail is made for unless told otherwise.
SMALLEST_PHASE = 0.5

Block = Complex[np.ndarray, "member member"]


@dataclass(frozen=True)
class Gradient:
    """Gradient of an axisymmetric flow at the targets: d_k u_i for i, k of r and z, and u_r/r."""

    rr: Meridian
    rz: Meridian
    zr: Meridian
    zz: Meridian
    around: Meridian

    def __add__(self, other: "Gradient") -> "Gradient":
        return Gradient(
            self.rr + other.rr,
            self.rz + other.rz,
            self.zr + other.zr,
            self.zz + other.zz,
            self.around + other.around,
        )

    def carried(self, members: Float[np.ndarray, "3 member point"]) -> MemberMatrix:
        """dx . grad u for the members' displacements dx of the targets."""
        radial, around, axial = members.transpose(0, 2, 1)
        rr, rz, zr, zz, pp = (
            each[:, None] for each in (self.rr, self.rz, self.zr, self.zz, self.around)
        )
        return np.stack([rr * radial + rz * axial, pp * around, zr * radial + zz * axial], axis=1)


class TrainFlow:
    """The flow about one shape of the cells of a train, viscosities inside and outside equal.

    **Arguments:** `membrane` of the cells; `profile`: their shape; `radius` of the tube and
    `period` of one cell, r0; `rules`; `largest_azimuthal_number` and `smallest_phase` (q > 0,
    radians) that will be asked for.
    """

    def __init__(
        self,
        membrane: AxisymmetricMembrane,
        profile: Profile,
        *,
        radius: float,
        period: float,
        rules: Rules,
        largest_azimuthal_number: int = 0,
        smallest_phase: float = SMALLEST_PHASE,
    ) -> None:
        self.membrane, self.profile = membrane, profile
        self.radius, self.period, self.rules = radius, period, rules
        self.degree = profile.shape[1]
        self.targets = meridian_grid(self.degree, rules.targets)
        self.sources = meridian_grid(self.degree, rules.sources)
        self.largest = largest_azimuthal_number
        self._smallest_phase = smallest_phase
        self._walls: dict[float, WallWaves] = {}
        self.energy = membrane.second_order(profile)
        self.force: Profile = membrane.force(self.energy)
        self.places = self.targets.places(profile)
        self.source_places = self.sources.places(profile)
        self.source_forces = self.sources.places(self.force)

    # ------------------------------------------------------------------- parts, made when needed

    @cached_property
    def own(self) -> OwnMoments:
        """Moments of the cell itself."""
        rules = self.rules
        rule = own_rule(self.degree, rules.targets, rules.radial, rules.half_circle)
        return force_moments(rule, self.profile, self.force)

    @cached_property
    def image_grid(self) -> tuple[MeridianGrid, HalfCircle]:
        """The product grid of the nearest images."""
        rules = self.rules
        return meridian_grid(self.degree, rules.image_sources), HalfCircle(rules.image_half_circle)

    @property
    def image_numbers(self) -> tuple[int, ...]:
        """Numbers p of the nearest images."""
        nearest = self.rules.nearest
        return tuple(p for p in range(-nearest, nearest + 1) if p != 0)

    @cached_property
    def images(self) -> dict[int, ImageMoments]:
        """Moments of the nearest images, by their number p."""
        grid, circle = self.image_grid
        return {
            p: force_image(
                grid,
                circle,
                self.places,
                self.profile,
                self.force,
                p * self.period,
                self.largest + 2,
            )
            for p in self.image_numbers
        }

    @cached_property
    def tail(self) -> Tail:
        """The farther images."""
        z = np.concatenate([self.places[0], self.source_places[0]])
        nearest = self.rules.nearest
        return Tail(
            period=self.period,
            nearest=nearest,
            distance=(nearest + 1) * self.period - float(z.max() - z.min()),
            smallest_phase=self._smallest_phase,
            tolerance=self.rules.tolerance,
            sources=self.source_places,
            targets=self.places,
            orders=self.largest + 3,
        )

    @cached_property
    def wall_distance(self) -> float:
        """Distance of the cells' points from the wall, r0."""
        return self.radius - float(max(self.places[1].max(), self.source_places[1].max()))

    def wall_waves(self, phase: float) -> WallWaves:
        """The wall's waves of a phase q."""
        if phase not in self._walls:
            (z, rho), (z_target, rho_target) = self.source_places, self.places
            self._walls[phase] = WallWaves(
                phase=phase,
                radius=self.radius,
                period=self.period,
                wall_distance=self.wall_distance,
                tolerance=self.rules.tolerance,
                rho=np.concatenate([rho, rho_target]),
                z=np.concatenate([z, z_target]),
                sources=len(z),
                orders=self.largest + 3,
            )
        return self._walls[phase]

    def wall_flows(self, phase: float, m: int) -> Iterator[WallFlow]:
        """What the wall adds for a phase and an azimuthal number: the parts of a sum."""
        for waves in self.wall_waves(phase).groups():
            yield WallFlow(waves, m)

    # --------------------------------------------------------------------------- the steady flow

    @cached_property
    def _flow(self) -> tuple[Float[np.ndarray, "target 3"], Gradient, float]:
        """Velocity at the targets, its gradient there for moving targets, and q0."""
        (_, rho), radius = self.places, self.radius
        force = np.concatenate([self.force[0], self.force[1][1:], np.zeros(self.degree - 1)])
        on_sources = (self.sources.sources(0) @ force)[:, None]
        velocity = member_matrix(self.own.at, SINGLE, 0) @ force
        integrals = self.own.integrals
        for image in self.images.values():
            velocity = velocity + member_matrix(image.at, SINGLE, 0) @ force
            integrals = integrals + image.integrals
        xx, xz, zx, zz, yy = integrals[4:9]
        gradient = Gradient(xx, xz, zx, zz, yy)
        moments = self.tail.of_resting_forces(0, on_sources)
        smooth = self.tail.velocity(0, ALIKE, moments)
        by_radius, by_height = self.tail.gradient(0, ALIKE, moments)
        for wall in self.wall_flows(ALIKE, 0):
            sums = wall.of_resting_forces(on_sources)
            smooth = smooth + wall.velocity(sums)
            along_radius, along_height = wall.gradient(sums)
            by_radius, by_height = by_radius + along_radius, by_height + along_height
        smooth, by_radius, by_height = (
            each.real[..., 0] for each in (smooth, by_radius, by_height)
        )
        velocity = velocity + smooth
        q0 = flow_rate.extra_flux(
            self.source_forces[0],
            self.source_places[1],
            2.0 * np.pi * self.sources.weights,
            radius,
            self.period,
        )
        velocity[:, 2] += flow_rate.parabola(rho, radius) * (1.0 - q0)
        shear = -4.0 * rho / radius**2 * (1.0 - q0)
        gradient = gradient + Gradient(
            by_radius[:, 0],
            by_height[:, 0],
            by_radius[:, 2] + shear,
            by_height[:, 2],
            smooth[:, 0] / rho,
        )
        return velocity, gradient, q0

    @property
    def velocity(self) -> Float[np.ndarray, "target 3"]:
        """R, Phi, Z of the velocity at the targets, in U."""
        return self._flow[0]

    @property
    def effective_viscosity(self) -> float:
        """Viscosity of the plain fluid with the same pressure drop at the same flow rate, mu."""
        return 1.0 - self._flow[2]

    @cached_property
    def volume_gradient(self) -> Float[np.ndarray, " member"]:
        """n = dV/ds in the members of m = 0."""
        return self.membrane.volume_gradient(self.profile)

    @cached_property
    def _uncut(self) -> Float[np.ndarray, " member"]:
        """P u, with what would change the volume."""
        return self.targets.projection(0) @ self.velocity.ravel()

    @cached_property
    def rates(self) -> Float[np.ndarray, " member"]:
        """Rates of change v of the shape, in the members of m = 0, U."""
        n, u = self.volume_gradient, self._uncut
        return u - n * (n @ u) / (n @ n)

    def at_targets(self, rates: Float[np.ndarray, " member"]) -> Float[np.ndarray, "target 3"]:
        """R, Phi, Z at the targets of a field with these members of m = 0."""
        return np.einsum("cmt,m->tc", self.targets.members(0), rates)

    # ----------------------------------------------------------------------------- the dynamics

    def blocks(self, m: int, phases: Sequence[float]) -> Complex[np.ndarray, "phase member member"]:
        """A_m(q) for phases q (radians per cell), in the members of azimuthal number m, U/r0."""
        hessian = self.membrane.hessian(self.energy, m)
        displaced = self.sources.sources(m)
        forced = -displaced @ hessian
        _, gradient, _ = self._flow
        still = self._changed(self.own, m, hessian) + gradient.carried(self.targets.members(m))
        images = {p: self._changed(image, m, hessian) for p, image in self.images.items()}
        moments = self.tail.of_forces(m, self.source_forces, displaced, forced)
        found = []
        for q in phases:
            velocity = still + sum(np.exp(1j * q * p) * each for p, each in images.items())
            velocity = velocity + self.tail.velocity(m, q, moments)
            for wall in self.wall_flows(q, m):
                velocity += wall.velocity(wall.of_forces(self.source_forces, displaced, forced))
            if m == 0 and q == ALIKE:
                velocity[:, 2] -= self._held(displaced, forced)
            block = self.targets.projection(m) @ velocity.reshape(-1, velocity.shape[-1])
            found.append(self._conserving(m, block))
        return np.stack(found)

    def _changed(
        self, part: OwnMoments | ImageMoments, m: int, hessian: Float[np.ndarray, "member member"]
    ) -> MemberMatrix:
        """U_G(-H_m) - U_D of one surface."""
        single = member_matrix(part.at, SINGLE, m)
        return -(single @ hessian) - member_matrix(part.at, SLOPE, m)

    def _held(
        self, displaced: Amplitudes, forced: Amplitudes
    ) -> Float[np.ndarray, "target member"]:
        """The parabola that holds the flow rate."""
        change = flow_rate.extra_flux_change(
            self.source_forces[0],
            self.source_places[1],
            self.radius,
            self.period,
            displaced,
            forced,
        )
        return np.outer(flow_rate.parabola(self.places[1], self.radius), change)

    def _conserving(self, m: int, block: Block) -> Block:
        """The derivative of v from that of P u."""
        n, u = self.volume_gradient, self._uncut
        size = n @ n
        along = (n @ u) / size
        curved = self.membrane.volume_hessian(self.profile, m)
        if m > 0:
            return block - along * curved
        block = block - np.outer(n, n @ block) / size - along * curved
        return block - np.outer(n, (u - 2.0 * along * n) @ curved) / size
