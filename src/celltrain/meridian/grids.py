"""Where velocities are evaluated on a meridian, and where smooth sources are sampled."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from jaxtyping import Float

from celltrain.harmonics import (
    LegendreTables,
    Profile,
    azimuthal_weight,
    cylindrical_members,
    gauss_colatitudes,
    legendre_tables,
)

Meridian = Float[np.ndarray, " point"]
#: R at all points, then Phi, then Z, of each member.
Amplitudes = Float[np.ndarray, "amplitude member"]


class MeridianGrid:
    """Gauss-Legendre colatitudes from 0 to pi, with the Legendre functions below a degree.

    `weights` are those of cos(theta); times 2 pi they are solid angles. Tables are made for the
    orders that are asked for.
    """

    def __init__(self, degree: int, order: int) -> None:
        self.degree = degree
        self.theta, self.weights = gauss_colatitudes(order)
        self._tables: LegendreTables | None = None
        self._members: dict[int, Float[np.ndarray, "3 member point"]] = {}

    @property
    def size(self) -> int:
        """Number of points."""
        return self.theta.size

    def tables(self, largest_order: int) -> LegendreTables:
        """Legendre functions and their derivatives, of these orders at least."""
        if self._tables is None or len(self._tables.value) <= largest_order:
            self._tables = legendre_tables(self.degree, largest_order, self.theta)
        return self._tables

    def members(self, m: int) -> Float[np.ndarray, "3 member point"]:
        """Amplitudes R, Phi, Z of the members of azimuthal number m."""
        if m not in self._members:
            self._members[m] = cylindrical_members(self.tables(m + 1).value, m)
        return self._members[m]

    def sources(self, m: int) -> Amplitudes:
        """From members to their amplitudes times the weights of solid angle, one after another."""
        weighted = self.members(m) * (2.0 * np.pi * self.weights)
        return np.ascontiguousarray(np.moveaxis(weighted, 1, 2).reshape(-1, weighted.shape[1]))

    def projection(self, m: int) -> Float[np.ndarray, "member point_3"]:
        """From amplitudes [point, 3] to the coefficients of the members."""
        weighted = self.members(m) * (azimuthal_weight(m) * self.weights)
        return np.moveaxis(weighted, 0, 2).reshape(weighted.shape[1], -1)

    def places(self, profile: Profile) -> tuple[Meridian, Meridian]:
        """Axial position and distance from the axis of the points, or a field's components so."""
        value = self.tables(1).value
        return profile[0] @ value[0], profile[1] @ value[1]

    def area_vectors(self, profile: Profile) -> tuple[Meridian, Meridian]:
        """Axial and radial component of the outward n dS/dOmega."""
        tables = self.tables(1)
        rho = profile[1] @ tables.value[1]
        rho_slope, z_slope = profile[1] @ tables.slope[1], profile[0] @ tables.slope[0]
        stretch = rho / np.sin(self.theta)
        return rho_slope * stretch, -z_slope * stretch


@lru_cache(maxsize=32)
def meridian_grid(degree: int, order: int) -> MeridianGrid:
    """The grid of `order` points for shapes below `degree`; one object for equal sizes."""
    return MeridianGrid(degree, order)


@dataclass(frozen=True)
class HalfCircle:
    """Uniform longitudes on half of the circle, half a step off its ends.

    Integrands that are even in phi, or odd and multiplied by an odd one, are twice their half;
    `weight` holds the factor.
    """

    count: int

    @cached_property
    def phi(self) -> Meridian:
        """The longitudes, radians."""
        return (np.arange(self.count) + 0.5) * np.pi / self.count

    @property
    def weight(self) -> float:
        """Weight of each, of the whole circle."""
        return 2.0 * np.pi / self.count

    def cosines(self, orders: int) -> Float[np.ndarray, "point order"]:
        """cos(o phi) for o < `orders`."""
        return np.cos(np.outer(self.phi, np.arange(orders)))

    def sines(self, orders: int) -> Float[np.ndarray, "point order"]:
        """sin(o phi) for o < `orders`."""
        return np.sin(np.outer(self.phi, np.arange(orders)))
