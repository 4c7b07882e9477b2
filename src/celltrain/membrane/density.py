"""Energy per reference area of a membrane, from six numbers at each point of its surface.

With x_t = dx/dtheta and x_p = dx/dphi, these are the metric a_ij = x_i . x_j and

    c_ij = x_ij . (x_t x x_p) = sqrt(det a) b_ij,   b_ij = n . x_ij the curvature form:

polynomials in the derivatives of x. All else, invariants and curvatures, is made of them here.
"""

from typing import NamedTuple

from celltrain.laws.arithmetic import Number
from celltrain.laws.bending import BendingLaw, Mixed
from celltrain.laws.constitutive import ConstitutiveLaw


class Forms(NamedTuple):
    """The six numbers: components tt, tp, pp of a_ij and of c_ij."""

    a11: Number
    a12: Number
    a22: Number
    c11: Number
    c12: Number
    c22: Number


class RestGeometry(NamedTuple):
    """What the energy needs of the reference surface.

    `inverse_metric` has the components tt, tp, pp of A^-1; `curvature` is A^-1 B; `area` is
    sqrt(det A) = dA_0/(dtheta dphi).
    """

    inverse_metric: tuple[Number, Number, Number]
    curvature: Mixed
    area: Number


def rest_geometry(forms: Forms) -> RestGeometry:
    """The reference geometry of a surface."""
    determinant = _determinant(forms)
    inverse = (forms.a22 / determinant, -forms.a12 / determinant, forms.a11 / determinant)
    return RestGeometry(inverse, _curvature(forms), area_density(forms))


def area_density(forms: Forms) -> Number:
    """sqrt(det a): area per dtheta dphi."""
    return _determinant(forms) ** 0.5


def invariants(forms: Forms, rest: RestGeometry) -> tuple[Number, Number]:
    """Strain invariants I1 = tr(C) - 2 and I2 = det(C) - 1 of C = A^-1 a."""
    g11, g12, g22 = rest.inverse_metric
    first = g11 * forms.a11 + (2.0 * g12) * forms.a12 + g22 * forms.a22 - 2.0
    return first, _determinant(forms) / rest.area**2 - 1.0


def energy_density(
    law: ConstitutiveLaw, bending: BendingLaw, forms: Forms, rest: RestGeometry
) -> Number:
    """W(I1, I2) + B(kappa, kappa_ref) per reference area, in mu U."""
    in_plane = law.energy_density(*invariants(forms, rest))
    dilatation = area_density(forms) / rest.area
    return in_plane + bending.energy_density(_curvature(forms), rest.curvature, dilatation)


def _determinant(forms: Forms) -> Number:
    return forms.a11 * forms.a22 - forms.a12 * forms.a12


def _curvature(forms: Forms) -> Mixed:
    """The mixed curvature a^-1 b."""
    a11, a12, a22, c11, c12, c22 = forms
    scale = _determinant(forms) ** -1.5
    return (
        (a22 * c11 - a12 * c12) * scale,
        (a22 * c12 - a12 * c22) * scale,
        (a11 * c12 - a12 * c11) * scale,
        (a11 * c22 - a12 * c12) * scale,
    )
