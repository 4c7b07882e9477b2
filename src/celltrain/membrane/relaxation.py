"""The energy that a resting shape minimises, and what is held while it does.

The membrane's, and below a reduced volume of about 0.61, where the two faces of the dimple would
meet, that of a repulsion which keeps them apart while the shape forms: with h = 2 z/n_z the
thickness along the normal, from one face to its mirror image,

    P = K int_(upper face) max(0, 1 - h/range)^3 dA,

finite and of short range. It is zero for all larger reduced volumes, and the finished shape has no
part of it.
"""

from dataclasses import dataclass
from functools import cache
from math import pi

import numpy as np
from jaxtyping import Float

from celltrain.harmonics import Profile
from celltrain.laws.arithmetic import Number
from celltrain.membrane.axisymmetric import AxisymmetricMembrane, axisymmetric_membrane
from celltrain.membrane.jets import Jet, variables
from celltrain.membrane.material import cell_material
from celltrain.membrane.reference import reference_profile
from celltrain.membrane.stationary import Derivatives, Held, Unknowns
from celltrain.parameters import Cell

#: Thickness, in r0, below which the faces of a cell repel each other while it forms.
REPULSION_RANGE = 0.2
#: Energy of the repulsion for each area where the faces touch, mu U.
REPULSION_STRENGTH = 10.0
#: Order of the rule along the meridian; the densities are no polynomials.
LEAST_ORDER = 48


@dataclass(frozen=True)
class Relaxation:
    """A cell's energy, area and volume as functions of its free coefficients.

    These are z_n and rho_n of odd degrees n of a profile: the mirror plane is z = 0. `repulsion` is
    K, in mu U.
    """

    membrane: AxisymmetricMembrane
    repulsion: float

    @property
    def degree(self) -> int:
        """The degree below which shapes are."""
        return self.membrane.meridian.degree

    def profile(self, unknowns: Unknowns) -> Profile:
        """The profile of a shape."""
        profile = np.zeros((2, self.degree))
        profile[:, 1::2] = unknowns.reshape(2, -1)
        return profile

    def unknowns(self, profile: Profile) -> Unknowns:
        """The free coefficients of a shape that has a mirror plane."""
        return profile[:, 1::2].ravel()

    def energy(self, unknowns: Unknowns) -> float:
        """Energy of the membrane and of the repulsion, mu U r0^2."""
        profile = self.profile(unknowns)
        repulsion = self._around @ _repulsion(*self._upper_surface(profile))
        return self.membrane.energy(profile) + self.repulsion * float(repulsion)

    def held(self, unknowns: Unknowns) -> Held:
        """Area, r0^2, and volume, r0^3."""
        profile = self.profile(unknowns)
        return np.array([self.membrane.area(profile), self.membrane.volume(profile)])

    def derivatives(self, unknowns: Unknowns) -> Derivatives:
        """First and second derivatives of both."""
        profile = self.profile(unknowns)
        cell = self.membrane
        pointwise = cell.second_order(profile)
        repulsion = _repulsion(*variables(np.array(self._upper_surface(profile))))
        tables = self._upper_tables
        weights = self.repulsion * self._around
        push = np.einsum("vup,pv,p->u", tables, repulsion.gradient, weights)
        push_slope = np.einsum("vup,pvw,wtp,p->ut", tables, repulsion.hessian, tables, weights)
        area_gradient, area_hessian = cell.area_derivatives(profile)
        # Among the members of m = 0.
        odd = np.arange(1, self.degree, 2)
        free = np.append(odd, self.degree - 1 + odd)
        block = np.ix_(free, free)
        return Derivatives(
            gradient=push - self.unknowns(cell.force(pointwise)),
            hessian=push_slope + cell.hessian(pointwise, 0)[block],
            normals=np.stack([area_gradient[free], cell.volume_gradient(profile)[free]]),
            bends=np.stack([area_hessian[block], cell.volume_hessian(profile, 0)[block]]),
        )

    def least_thickness(self, unknowns: Unknowns) -> float:
        """The least thickness along the normals, r0; negative if the faces cross."""
        return float(_thickness(*self._upper_surface(self.profile(unknowns))).min())

    @property
    def _upper(self) -> np.ndarray:
        return self.membrane.meridian.theta < 0.5 * pi

    @property
    def _around(self) -> Float[np.ndarray, " point"]:
        """Weights of the upper face."""
        return 2.0 * pi * self.membrane.meridian.weights[self._upper]

    def _upper_surface(self, profile: Profile) -> tuple[np.ndarray, ...]:
        """rho, rho', z, z' of the upper face."""
        rho, rho_1, _, z, z_1, _ = self.membrane.meridian.profile(profile)
        return tuple(each[self._upper] for each in (rho, rho_1, z, z_1))

    @property
    def _upper_tables(self) -> Float[np.ndarray, "4 unknown point"]:
        """Derivatives of these four by the unknowns."""
        legendre = self.membrane.meridian.legendre(1)
        value, slope = (each[:2, 1::2, self._upper] for each in (legendre.value, legendre.slope))
        none = np.zeros_like(value[0])
        return np.stack(
            [
                np.concatenate([none, value[1]]),
                np.concatenate([none, slope[1]]),
                np.concatenate([value[0], none]),
                np.concatenate([slope[0], none]),
            ]
        )


def _thickness(rho: Number, rho_slope: Number, z: Number, z_slope: Number) -> Number:
    """h = 2 z/n_z."""
    del rho
    return 2.0 * z * (rho_slope**2 + z_slope**2) ** 0.5 / rho_slope


def _repulsion(rho: Number, rho_slope: Number, z: Number, z_slope: Number) -> Number:
    """max(0, 1 - h/range)^3 for each area, times the area for each dtheta dphi."""
    overlap = 1.0 - _thickness(rho, rho_slope, z, z_slope) / REPULSION_RANGE
    size = overlap.value if isinstance(overlap, Jet) else overlap
    area = rho * (rho_slope**2 + z_slope**2) ** 0.5
    return overlap**3 * area * (size > 0.0)


@cache
def relaxation(degree: int) -> Relaxation:
    """The problem for shapes below `degree`."""
    law, bending = cell_material(Cell())
    healthy = reference_profile(degree, "biconcave")
    order = max(LEAST_ORDER, 3 * degree)
    membrane = axisymmetric_membrane(law, bending, healthy, energy_order=order)
    return Relaxation(membrane, REPULSION_STRENGTH)
