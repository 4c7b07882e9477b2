"""Cells of another viscosity than the plasma: the double layer on the meridian.

With lam the viscosity ratio and b the velocity at equal viscosities, B u = b with

    B = (1 + lam)/2 - (1 - lam) K,   K u = (1/8 pi) PV int K_ij u_j dOmega + images, tail and wall.

In a steady train u is a rigid motion, and B u = u for rigid motions whatever the shape: the train
does not depend on lam, and A_m(q; lam) = B_m(q)^-1 A_m(q; 1).

On the own surface K u = sum K (u(y) - u(x)) - u(x)/2, in which nothing is singular. An inflation of
a cell is no disturbance that its volume allows; what the far images and the wall make of it has no
limit at q = 0 and is taken out. That changes no rates: B^-1 makes no inflation where there is none.
The flux of the double layer is held as that of the forces is. Rigid motions of a cell give -1/2 of
themselves, which the discrete K does to rounding.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Complex, Float

from celltrain.meridian import flow_rate
from celltrain.meridian.images import stress_image
from celltrain.meridian.moments import STRESS, member_matrix
from celltrain.meridian.own_surface import own_rule, stress_moments
from celltrain.meridian.train import ALIKE, Gradient, TrainFlow


class DoubleLayer:
    """K_m(q) about one shape of a train's cells."""

    def __init__(self, flow: TrainFlow) -> None:
        self._flow = flow
        rules = flow.rules
        rule = own_rule(flow.degree, rules.targets, rules.radial, rules.half_circle)
        self._own = stress_moments(rule, flow.profile)
        xx, xz, zz, yy = self._own.integrals
        self._constants = Gradient(xx, xz, xz, zz, yy)
        grid, circle = flow.image_grid
        self._images = {
            p: stress_image(
                grid, circle, flow.places, flow.profile, p * flow.period, flow.largest + 2
            )
            for p in flow.image_numbers
        }
        self._area = flow.sources.area_vectors(flow.profile)

    def blocks(self, m: int, phases: Sequence[float]) -> Complex[np.ndarray, "phase member member"]:
        """K_m(q) for phases q (radians per cell), in the members of azimuthal number m."""
        members = self._flow.targets.members(m)
        velocity = member_matrix(self._own.at, STRESS, m) - self._constants.carried(members)
        velocity = velocity - 0.5 * members.transpose(2, 0, 1)
        return self._block(m, velocity) + self.blocks_of_others(m, phases)

    def blocks_of_others(
        self, m: int, phases: Sequence[float]
    ) -> Complex[np.ndarray, "phase member member"]:
        """The part of K_m(q) that does not come from the cell's own surface in free space."""
        flow, area = self._flow, self._area
        displaced = flow.sources.sources(m) @ self._without_inflation(m)
        images = {p: member_matrix(each.at, STRESS, m) for p, each in self._images.items()}
        moments = flow.tail.of_stresses(m, area, displaced)
        found = []
        for q in phases:
            velocity = flow.tail.velocity(m, q, moments)
            velocity = velocity + sum(np.exp(1j * q * p) * each for p, each in images.items())
            for wall in flow.wall_flows(q, m):
                velocity += wall.velocity(wall.of_stresses(area, displaced))
            if m == 0 and q == ALIKE:
                (z, rho), radius = flow.source_places, flow.radius
                flux = flow_rate.stress_flux(area, z, rho, radius, flow.period, displaced)
                velocity[:, 2] -= np.outer(flow_rate.parabola(flow.places[1], radius), flux)
            found.append(self._block(m, velocity))
        return np.stack(found)

    def equation(
        self, m: int, phases: Sequence[float], viscosity_ratio: float
    ) -> Complex[np.ndarray, "phase member member"]:
        """B_m(q) = (1 + lam)/2 - (1 - lam) K_m(q)."""
        layer = self.blocks(m, phases)
        unit = np.eye(layer.shape[-1])
        return 0.5 * (1.0 + viscosity_ratio) * unit - (1.0 - viscosity_ratio) * layer

    def _without_inflation(self, m: int) -> Float[np.ndarray, "member member"]:
        size = self._flow.targets.members(m).shape[1]
        if m > 0:
            return np.eye(size)
        n = self._flow.volume_gradient
        return np.eye(size) - np.outer(n, n) / (n @ n)

    def _block(self, m: int, velocity: np.ndarray) -> np.ndarray:
        """The block of a velocity at the targets, less the changes of volume that K has none of."""
        block = self._flow.targets.projection(m) @ velocity.reshape(-1, velocity.shape[-1])
        if m > 0:
            return block
        n = self._flow.volume_gradient
        return block - np.outer(n, n @ block) / (n @ n)
