"""A cell's own surface in free space: a polar rule about every target.

In polar coordinates (alpha, beta) of the parameter sphere about a target the area element
sin(alpha) cancels 1/|d|: Gauss-Legendre in alpha, uniform in beta over half of the circle, as all
fields are even or odd. Sums over beta, then over alpha, give moments in the rotated frame,

    B[mu, n] = sum K P_n,mu(alpha) (cos or sin)(mu beta),

and one small rotation (`harmonics.meridian_rotation`) those of the usual orders. Prefactor 1/8 pi.
"""

from collections.abc import Callable, Iterator
from functools import lru_cache

import numpy as np
from jaxtyping import Float

from celltrain.harmonics import Profile
from celltrain.harmonics.legendre import legendre_tables
from celltrain.harmonics.meridian_rotation import meridian_rotation
from celltrain.meridian.grids import HalfCircle, MeridianGrid, meridian_grid
from celltrain.meridian.kernels import (
    EVEN,
    ODD,
    STRESS_EVEN,
    STRESS_ODD,
    force_fields,
    stress_fields,
)
from celltrain.meridian.moments import Moments

# Bytes of the fields at once: targets are taken in groups of that size.
GROUP = 2**25


class OwnRule:
    """The polar rule of a degree's targets; nothing of it depends on the shape."""

    def __init__(self, targets: MeridianGrid, radial: int, half_circle: int) -> None:
        self.targets = targets
        self.degree = targets.degree
        nodes, gauss = np.polynomial.legendre.leggauss(radial)
        self.alpha = 0.5 * np.pi * (nodes + 1.0)
        circle = HalfCircle(half_circle)
        self.beta = circle.phi
        area = 0.5 * np.pi * gauss * np.sin(self.alpha) * circle.weight / (8.0 * np.pi)
        self.weights = np.repeat(area, half_circle)
        self.cosines, self.sines = circle.cosines(self.degree), circle.sines(self.degree)
        tables = legendre_tables(self.degree, self.degree - 1, self.alpha)
        # [mu, alpha, n]
        self.value = np.ascontiguousarray(np.moveaxis(tables.value, 1, 2))
        self.slope = np.ascontiguousarray(np.moveaxis(tables.slope, 1, 2))
        self._poles = tuple(targets.theta.tolist())

    def rotation(self, order: int) -> tuple[np.ndarray, np.ndarray]:
        """Even and odd rotation of an order, [target, n, mu]."""
        return meridian_rotation(self.degree, order, self._poles)

    def groups(self) -> Iterator[slice]:
        """Targets in groups whose fields fit in little memory."""
        each = 8 * (len(EVEN) + len(ODD) + 6) * self.weights.size
        step = max(1, GROUP // each)
        for first in range(0, self.targets.size, step):
            yield slice(first, min(first + step, self.targets.size))

    def field(self, profile: Profile, group: slice) -> Float[np.ndarray, "3 target node"]:
        """Cartesian components of an axisymmetric field at the nodes of some targets."""
        axial, radial = profile
        (even, odd), (still, _) = self.rotation(1), self.rotation(0)
        return np.stack(
            [
                self._at_nodes(radial, even[group], self.value, self.cosines),
                self._at_nodes(radial, odd[group], self.value, self.sines),
                self._at_nodes(axial, still[group], self.value, self.cosines),
            ]
        )

    def area_vectors(self, profile: Profile, group: slice) -> Float[np.ndarray, "3 target node"]:
        """n dS/dOmega at the nodes: x_alpha x x_beta/sin(alpha)."""
        axial, radial = profile
        (even, odd), (still, _) = self.rotation(1), self.rotation(0)
        mu = np.arange(self.degree)
        across = self.value * (mu[:, None] / np.sin(self.alpha))[:, :, None]
        parts = (
            (radial, even[group], self.cosines, -self.sines),
            (radial, odd[group], self.sines, self.cosines),
            (axial, still[group], self.cosines, -self.sines),
        )
        down = [self._at_nodes(c, r, self.slope, turn) for c, r, turn, _ in parts]
        along = [self._at_nodes(c, r, across, turn) for c, r, _, turn in parts]
        return np.cross(np.stack(down), np.stack(along), axis=0)

    def _at_nodes(
        self, coefficients: np.ndarray, rotation: np.ndarray, latitude: np.ndarray, turn: np.ndarray
    ) -> np.ndarray:
        """sum_n,mu c_n D[t, n, mu] latitude[mu, alpha, n] turn[beta, mu], [target, node]."""
        rotated = np.ascontiguousarray((rotation * coefficients[:, None]).transpose(2, 1, 0))
        by_order = np.matmul(latitude, rotated)  # mu, alpha, target
        values = by_order.transpose(2, 1, 0) @ turn.T
        return values.reshape(rotation.shape[0], -1)

    def reduce(
        self, fields: Float[np.ndarray, "field target node"], turn: np.ndarray
    ) -> Float[np.ndarray, "target n field mu"]:
        """The moments B of the module."""
        count, targets, _ = fields.shape
        radial, degree = self.alpha.size, self.degree
        by_order = fields.reshape(count * targets * radial, -1) @ turn
        by_order = np.ascontiguousarray(by_order.reshape(count * targets, radial, degree).T)
        summed = np.matmul(by_order.transpose(0, 2, 1), self.value)  # mu, field target, n
        return np.ascontiguousarray(
            summed.reshape(degree, count, targets, degree).transpose(2, 3, 1, 0)
        )


@lru_cache(maxsize=8)
def own_rule(degree: int, targets: int, radial: int, half_circle: int) -> OwnRule:
    """The rule for shapes below `degree`; one object for equal sizes."""
    return OwnRule(meridian_grid(degree, targets), radial, half_circle)


class OwnMoments:
    """Moments of a kernel over the cell's own surface, and its integrals over it.

    `integrals` are the sums of the even fields: what the kernel makes of constants.
    """

    def __init__(
        self,
        rule: OwnRule,
        integrals: Float[np.ndarray, "field target"],
        even: Float[np.ndarray, "target n field mu"],
        odd: Float[np.ndarray, "target n other_field mu"],
    ) -> None:
        self.integrals = integrals
        self.rule = rule
        self._fields = even, odd
        self._kept: dict[int, tuple[Moments, Moments]] = {}

    def at(self, order: int) -> tuple[Moments, Moments]:
        """Moments of the even and the odd fields for an order."""
        if order not in self._kept:
            found = []
            for moments, rotation in zip(self._fields, self.rule.rotation(order), strict=True):
                turned = np.matmul(moments, rotation[..., None])[..., 0]
                found.append(np.moveaxis(turned, 2, 0))
            self._kept[order] = (found[0], found[1])
        return self._kept[order]


def force_moments(rule: OwnRule, profile: Profile, force: Profile) -> OwnMoments:
    """Moments of G and T for the forces of a cell, both as profiles."""

    def forces(group: slice) -> np.ndarray:
        return rule.field(force, group)

    return _moments(rule, profile, forces, force_fields, (EVEN, ODD))


def stress_moments(rule: OwnRule, profile: Profile) -> OwnMoments:
    """Moments of K for the shape of a cell."""

    def areas(group: slice) -> np.ndarray:
        return rule.area_vectors(profile, group)

    return _moments(rule, profile, areas, stress_fields, (STRESS_EVEN, STRESS_ODD))


def _moments(
    rule: OwnRule,
    profile: Profile,
    content: Callable[[slice], np.ndarray],
    kernel: Callable[..., None],
    names: tuple[tuple[str, ...], tuple[str, ...]],
) -> OwnMoments:
    """Moments of a kernel's fields for what the nodes of some targets carry."""
    z, rho = rule.targets.places(profile)
    parts = []
    for group in rule.groups():
        points = rule.field(profile, group)
        even, odd = (np.empty((len(each), *points.shape[1:])) for each in names)
        kernel(rho[group], z[group], points, content(group), rule.weights, even, odd)
        parts.append((even.sum(2), rule.reduce(even, rule.cosines), rule.reduce(odd, rule.sines)))
    integrals, of_even, of_odd = zip(*parts, strict=True)
    return OwnMoments(
        rule, np.concatenate(integrals, axis=1), np.concatenate(of_even), np.concatenate(of_odd)
    )
