"""Gauss points on the meridian of an axisymmetric cell, with the fields that live on them."""

from functools import lru_cache
from typing import TypeAlias

import numpy as np
from jaxtyping import Float

from celltrain.harmonics import (
    LegendreTables,
    Profile,
    cylindrical_members,
    gauss_colatitudes,
    legendre_tables,
)

Values: TypeAlias = Float[np.ndarray, " point"]


class Meridian:
    """Colatitudes, weights and tables of the harmonics below a degree on one meridian.

    `weights` integrate over dtheta, without the sine. Tables are made when they are asked for, and
    kept.
    """

    def __init__(self, degree: int, order: int) -> None:
        self.degree = degree
        self.theta, gauss = gauss_colatitudes(order)
        self.weights = gauss / np.sin(self.theta)
        self._legendre: LegendreTables | None = None
        self._tables: dict[int, Float[np.ndarray, "point 15 member"]] = {}

    def legendre(self, order: int) -> LegendreTables:
        """The Legendre functions of the orders up to the one given, or more."""
        known = 0 if self._legendre is None else len(self._legendre.value) - 1
        if self._legendre is None or known < order:
            # Twice as many at a time, as the next ones are likely to be asked for.
            largest = max(order, min(2 * known, self.degree + 1))
            self._legendre = legendre_tables(self.degree, largest, self.theta)
        return self._legendre

    def profile(self, profile: Profile) -> tuple[Values, Values, Values, Values, Values, Values]:
        """Distance from the axis and height, rho, rho', rho'', z, z', z'' by theta."""
        tables = self.legendre(1)
        parts = tables.value, tables.slope, tables.curvature
        rho, rho_1, rho_2 = (profile[1] @ part[1] for part in parts)
        z, z_1, z_2 = (profile[0] @ part[0] for part in parts)
        return rho, rho_1, rho_2, z, z_1, z_2

    def components(self, profile: Profile) -> Float[np.ndarray, "5 3 point"]:
        """x_t, x_p, x_tt, x_tp, x_pp of an axisymmetric shape at phi = 0."""
        rho, rho_1, rho_2, _, z_1, z_2 = self.profile(profile)
        none = np.zeros_like(rho)
        return np.array(
            [
                [rho_1, none, z_1],
                [none, rho, none],
                [rho_2, none, z_2],
                [none, rho_1, none],
                [-rho, none, none],
            ]
        )

    def member_components(self, m: int) -> Float[np.ndarray, "point 15 member"]:
        """The same of each member of azimuthal number m, as real amplitudes.

        On the meridian phi = 0, components that are even in phi (x_t along x and z, ...) vary as
        cos(m phi) and the odd ones as sin(m phi). An axisymmetric surface's energy does not couple
        the two, so that sums over both with real amplitudes are its second variation.
        """
        if m not in self._tables:
            tables = self.legendre(m + 1)
            (r, f, z), (r1, f1, z1), (r2, f2, z2) = (
                cylindrical_members(table, m)
                for table in (tables.value, tables.slope, tables.curvature)
            )
            rows = [r1, -f1, z1, m * r + f, m * f + r, m * z, r2, -f2, z2]
            rows += [m * r1 + f1, m * f1 + r1, m * z1]
            rows += [-(m * m + 1) * r - 2 * m * f, (m * m + 1) * f + 2 * m * r, -m * m * z]
            self._tables[m] = np.ascontiguousarray(np.array(rows).transpose(2, 0, 1))
        return self._tables[m]


@lru_cache(maxsize=8)
def meridian(degree: int, order: int) -> Meridian:
    """The points and tables of a rule, shared by all membranes that use it."""
    return Meridian(degree, order)
