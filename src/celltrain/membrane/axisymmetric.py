"""The membrane of an axisymmetric cell, and disturbances of it of any azimuthal number.

For profiles (see `harmonics.profile`), with the energy of `density` integrated along one meridian:

    E = 2 pi sum_theta w e,   F = -dE/ds,   H_m = c_m sum_theta w B_m^T D B_m,

with D the Hessian of the energy density e in the 15 components of `forms`, computed once for a
shape, B_m the 15 components of each member of azimuthal number m, and c_m = `azimuthal_weight`(m).
Agrees with the membrane for any shape (`energy`), to rounding where both use the same rings.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from celltrain.harmonics import Profile, azimuthal_weight, cylindrical_members
from celltrain.laws.bending import BendingLaw, MomentBending
from celltrain.laws.constitutive import ConstitutiveLaw
from celltrain.membrane.density import (
    Forms,
    RestGeometry,
    area_density,
    energy_density,
    in_plane_density,
    moment_work,
    rest_geometry,
)
from celltrain.membrane.forms import (
    PointwiseEnergy,
    fundamental_forms,
    in_components,
    with_turning,
)
from celltrain.membrane.jets import Jet, variables
from celltrain.membrane.meridian import Meridian, meridian

Vector = Float[np.ndarray, " member"]
Matrix = Float[np.ndarray, "member member"]


@dataclass(frozen=True)
class AxisymmetricMembrane:
    """A membrane with its law, bending energy and resting profile, for axisymmetric shapes.

    Members are those of `azimuthal_basis`; for m = 0 they begin with a profile's z_0, ..., z_(M-1),
    rho_1, ..., rho_(M-1), and end with the swirl.
    """

    law: ConstitutiveLaw
    bending: BendingLaw
    rest_profile: Profile
    meridian: Meridian
    rest: RestGeometry

    def energy(self, profile: Profile) -> float:
        """Elastic energy of one cell, in mu U r0^2.

        **Raises:** `CaseError` for bending moments, which have none.
        """
        forms = fundamental_forms(self.meridian.components(profile))
        density = energy_density(self.law, self.bending, forms, self.rest)
        return float(2.0 * np.pi * self._rest_weights @ density)

    def second_order(self, profile: Profile) -> PointwiseEnergy:
        """Derivatives of the energy density, per reference area, from which all else follows."""
        components = self.meridian.components(profile)
        forms = Forms(*variables(np.array(fundamental_forms(components))))
        if not isinstance(self.bending, MomentBending):
            return in_components(
                energy_density(self.law, self.bending, forms, self.rest), components
            )
        in_plane = in_plane_density(self.law, forms, self.rest)
        work = moment_work(self.bending, forms, self.rest)
        density = Jet(
            np.full_like(in_plane.value, np.nan),
            in_plane.gradient + np.stack([each.value for each in work.forms], axis=-1),
            in_plane.hessian + np.stack([each.gradient for each in work.forms], axis=1),
        )
        pointwise = in_components(density, components)
        if self.bending.BALANCED:
            return pointwise
        # Zero where the surface is one of revolution, but not its derivatives.
        return with_turning(pointwise, work.turning, components)

    def force(self, pointwise: PointwiseEnergy) -> Profile:
        """-dE/ds, or that of moments, in mu U r0: the force per solid angle.

        F_z in P_n0 (row 0) and F_rho in P_n1.
        """
        along = -self._gradient(pointwise, self._rest_weights)
        degree = self.meridian.degree
        return np.stack([along[:degree], np.append(0.0, along[degree : 2 * degree - 1])])

    def hessian(self, pointwise: PointwiseEnergy, m: int) -> Matrix:
        """H_m, second derivatives of the energy in the members of azimuthal number m, in mu U.

        In general minus the derivative (by columns) of the force (by rows).
        """
        return self._hessian(pointwise, self._rest_weights, m)

    def volume(self, profile: Profile) -> float:
        """Enclosed volume, in r0^3: (1/3) int x . (x_t x x_p) dtheta dphi."""
        rho, rho_1, _, z, z_1, _ = self.meridian.profile(profile)
        density = rho * (z * rho_1 - rho * z_1)
        return float(2.0 * np.pi / 3.0 * self.meridian.weights @ density)

    def volume_gradient(self, profile: Profile) -> Vector:
        """dV/ds by members of m = 0, in r0^2: amounts of n dS/dOmega."""
        rho, rho_1, _, _, z_1, _ = self.meridian.profile(profile)
        along, _, axial = cylindrical_members(self.meridian.legendre(1).value, 0)
        density = axial * (rho_1 * rho) - along * (z_1 * rho)
        return 2.0 * np.pi * density @ self.meridian.weights

    def volume_hessian(self, profile: Profile, m: int) -> Matrix:
        """Second derivatives of the volume in the members of azimuthal number m, in r0."""
        rho, rho_1, _, _, z_1, _ = self.meridian.profile(profile)
        tables = self.meridian.legendre(m + 1)
        along, around, axial = cylindrical_members(tables.value, m)
        along_1, _, axial_1 = cylindrical_members(tables.slope, m)
        # The change of n dS, from that of x_t x x_p.
        turn = m * around + along
        radial = -rho * axial_1 - z_1 * turn
        azimuthal = m * rho_1 * axial - z_1 * (m * along + around)
        upward = rho * along_1 + rho_1 * turn
        weights = azimuthal_weight(m) * self.meridian.weights
        return (
            (along * weights) @ radial.T
            + (around * weights) @ azimuthal.T
            + (axial * weights) @ upward.T
        )

    def area(self, profile: Profile) -> float:
        """Surface area, in r0^2."""
        forms = fundamental_forms(self.meridian.components(profile))
        return float(2.0 * np.pi * self.meridian.weights @ area_density(forms))

    def area_derivatives(self, profile: Profile) -> tuple[Vector, Matrix]:
        """First and second derivatives of the area in the members of m = 0, in r0 and 1."""
        components = self.meridian.components(profile)
        forms = Forms(*variables(np.array(fundamental_forms(components))))
        pointwise = in_components(area_density(forms), components)
        weights = self.meridian.weights
        return self._gradient(pointwise, weights), self._hessian(pointwise, weights, 0)

    @property
    def _rest_weights(self) -> Float[np.ndarray, " point"]:
        """Reference area per dphi of each point."""
        return self.meridian.weights * self.rest.area

    def _gradient(self, pointwise: PointwiseEnergy, weights: np.ndarray) -> Vector:
        weighted = (2.0 * np.pi * weights)[:, None] * pointwise.gradient
        return np.tensordot(weighted, self.meridian.member_components(0), 2)

    def _hessian(self, pointwise: PointwiseEnergy, weights: np.ndarray, m: int) -> Matrix:
        components = self.meridian.member_components(m)
        stiffness = (azimuthal_weight(m) * weights)[:, None, None] * pointwise.hessian
        flat = components.reshape(-1, components.shape[2])
        return flat.T @ (stiffness @ components).reshape(flat.shape)


def axisymmetric_membrane(
    law: ConstitutiveLaw, bending: BendingLaw, rest_profile: Profile, *, energy_order: int
) -> AxisymmetricMembrane:
    """Membrane that is free of stress at a profile, but for what its bending energy adds.

    **Arguments:** `energy_order`: Gauss-Legendre colatitudes at which the energy is integrated.
    """
    points = meridian(rest_profile.shape[1], energy_order)
    rest = rest_geometry(fundamental_forms(points.components(rest_profile)))
    return AxisymmetricMembrane(law, bending, rest_profile, points, rest)
