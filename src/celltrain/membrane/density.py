"""Energy per reference area of a membrane, from six numbers at each point of its surface.

With x_t = dx/dtheta and x_p = dx/dphi, these are the metric a_ij = x_i . x_j and

    c_ij = x_ij . (x_t x x_p) = sqrt(det a) b_ij,   b_ij = n . x_ij the curvature form:

polynomials in the derivatives of x. All else, invariants and curvatures, is made of them here: the
energy, and the work of bending moments, which have none.
"""

from typing import NamedTuple

from celltrain.laws.arithmetic import Number
from celltrain.laws.bending import BendingLaw, Mixed, MomentBending
from celltrain.laws.constitutive import ConstitutiveLaw
from celltrain.parameters import CaseError


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
    return RestGeometry(inverse, curvature(forms), area_density(forms))


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
    """W(I1, I2) + B(kappa, kappa_ref) per reference area, in mu U.

    **Raises:** `CaseError` for bending that has no energy.
    """
    if isinstance(bending, MomentBending):
        raise CaseError(
            "bending by moments has no energy: not allowed where an energy is asked for (Eq. 23);"
            " allowed there: bending = 'elastic', 'helfrich'"
        )
    dilatation = area_density(forms) / rest.area
    bent = bending.energy_density(curvature(forms), rest.curvature, dilatation)
    return in_plane_density(law, forms, rest) + bent


def in_plane_density(law: ConstitutiveLaw, forms: Forms, rest: RestGeometry) -> Number:
    """W(I1, I2) per reference area, in mu U."""
    return law.energy_density(*invariants(forms, rest))


class MomentWork(NamedTuple):
    """What bending moments do, per reference area, in place of derivatives of an energy.

    Against changes of the shape they do the work sum_i g_i d(form_i) + h (x_t . dx_p - x_p . dx_t),
    `forms` the numbers g_i (those of tp for both tp and pt), `turning` h, which a balance of the
    moments about the normal takes away.
    """

    forms: Forms
    turning: Number


def moment_work(bending: MomentBending, forms: Forms, rest: RestGeometry) -> MomentWork:
    """-M^ab (db_ab - b_a^c x_,c . dx_,b) dA/dA_0, in mu U."""
    a11, a12, a22, *_ = forms
    determinant = _determinant(forms)
    g11, g12, g22 = a22 / determinant, -a12 / determinant, a11 / determinant
    k11, k12, k21, k22 = curvature(forms)
    m11, m12, m21, m22 = bending.moments((k11, k12, k21, k22), rest.curvature)
    # -M^ab, then -b_a^c M^ab as [c, b].
    r11, r12 = m11 * g11 + m12 * g12, m11 * g12 + m12 * g22
    r21, r22 = m21 * g11 + m22 * g12, m21 * g12 + m22 * g22
    n11, n12 = k11 * r11 + k12 * r21, k11 * r12 + k12 * r22
    n21, n22 = k21 * r11 + k22 * r21, k21 * r12 + k22 * r22
    # db = dc/sqrt(det a) - b tr(a^-1 da)/2, and dA/dA_0 is sqrt(det a) over that at rest.
    stretched = area_density(forms) / rest.area
    trace = k11 * m11 + k12 * m21 + k21 * m12 + k22 * m22
    by_metric = (
        -0.5 * (stretched * (n11 + trace * g11)),
        -(stretched * (0.5 * (n12 + n21) + trace * g12)),
        -0.5 * (stretched * (n22 + trace * g22)),
    )
    by_form = r11 / rest.area, (r12 + r21) / rest.area, r22 / rest.area
    return MomentWork(Forms(*by_metric, *by_form), -0.5 * (stretched * (n12 - n21)))


def curvature(forms: Forms) -> Mixed:
    """The mixed curvature a^-1 b."""
    a11, a12, a22, c11, c12, c22 = forms
    scale = _determinant(forms) ** -1.5
    return (
        (a22 * c11 - a12 * c12) * scale,
        (a22 * c12 - a12 * c22) * scale,
        (a11 * c12 - a12 * c11) * scale,
        (a11 * c22 - a12 * c12) * scale,
    )


def _determinant(forms: Forms) -> Number:
    return forms.a11 * forms.a22 - forms.a12 * forms.a12
