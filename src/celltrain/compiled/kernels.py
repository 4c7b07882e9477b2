"""The kernels of a force and of a double layer in three dimensions: their arithmetic, once.

With d = x - y from source to target and r = |d|,

    G = A I + C d d,
    T_ijk = a (delta_ij d_k + delta_jk d_i + delta_ik d_j) + b d_i d_j d_k.

The near kernels of the Ewald splitting (Hasimoto 1959) have, with E = erfc(xi r)/r and
h = 2 xi/sqrt(pi) exp(-xi^2 r^2),

    A = E - h,   C = (E + h)/r^2,   A'/r = a - C,   C'/r = b/2,
    a = A'/r + C = 4 xi^3/sqrt(pi) exp(-xi^2 r^2),   b = 2 C'/r = -2 (3 C + a)/r^2,
    a'/r = -2 xi^2 a,   b'/r = -(5 b + 2 a'/r)/r^2;

with xi -> 0 they are those in free space, A = 1/r, C = 1/r^3, a = 0, b = -6/r^5. A double layer of
density w on an element with the normal N gives T(y - x)_ijk w_j N_k = -T(d)_ijk w_j N_k.

Numbers are floats in the loops that Numba compiles, and arrays in the plain formulas for JAX: both
are made of the lines below. Vectors are three numbers, symmetric matrices those of `SYMMETRIC`,
other ones nine, row by row.
"""

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from numba.extending import register_jitable

#: A float, or an array of JAX.
Number: TypeAlias = Any
Vector: TypeAlias = Sequence[Number]
#: A and C, or a and b; or their derivatives in r, over r.
Scalars: TypeAlias = tuple[Number, Number]

# Components of a symmetric matrix that are kept, and where each of the nine is among them.
SYMMETRIC = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
UNFOLD = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])


@register_jitable(inline="always")
def dot(a: Vector, b: Vector) -> Number:
    """a.b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@register_jitable(inline="always")
def squared(a: Vector) -> Number:
    """a.a, whose derivative in JAX is one product for each component."""
    return a[0] ** 2 + a[1] ** 2 + a[2] ** 2


@register_jitable(inline="always")
def cross(a: Vector, b: Vector) -> tuple[Number, Number, Number]:
    """a x b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@register_jitable(inline="always")
def stokeslet_scalars(screened: Number, gauss: Number, inverse_square: Number) -> Scalars:
    """A and C, from E, h and 1/r^2."""
    return screened - gauss, (screened + gauss) * inverse_square


@register_jitable(inline="always")
def stresslet_scalars(
    screened: Number, gauss: Number, inverse_square: Number, parameter: Number
) -> Scalars:
    """a and b, from E, h, 1/r^2 and xi."""
    linear = 2.0 * parameter * parameter * gauss
    core = (screened + gauss) * inverse_square
    return linear, -2.0 * (3.0 * core + linear) * inverse_square


@register_jitable(inline="always")
def free_stresslet(square: Number, inverse: Number) -> Number:
    """b in free space, -6/r^5, from r^2 and 1/r."""
    return (-6.0 / square**2) * inverse


def stokeslet_slopes(stokeslet: Scalars, stresslet: Scalars) -> Scalars:
    """A'/r and C'/r, from (A, C) and (a, b)."""
    return stresslet[0] - stokeslet[1], 0.5 * stresslet[1]


def stresslet_slopes(stresslet: Scalars, square: Number, parameter: float) -> Scalars:
    """a'/r and b'/r, from (a, b), r^2 and xi."""
    linear = -2.0 * parameter**2 * stresslet[0]
    return linear, -(5.0 * stresslet[1] + 2.0 * linear) / square


@register_jitable(inline="always")
def stokeslet(scalars: Scalars, d: Vector, force: Vector) -> tuple[Number, Number, Number]:
    """G f = A f + C (d.f) d."""
    isotropic, dyadic = scalars
    along = dyadic * dot(d, force)
    return (
        isotropic * force[0] + along * d[0],
        isotropic * force[1] + along * d[1],
        isotropic * force[2] + along * d[2],
    )


def stokeslet_matrix(scalars: Scalars, d: Vector) -> list[Number]:
    """Components of G."""
    isotropic, dyadic = scalars
    return [dyadic * d[i] * d[j] + (isotropic if i == j else 0.0) for i, j in SYMMETRIC]


def stokeslet_gradient(scalars: Scalars, slopes: Scalars, d: Vector, force: Vector) -> list[Number]:
    """Derivatives of (G f)_i by d_k, nine."""
    _, dyadic = scalars
    isotropic_slope, dyadic_slope = slopes
    along = dot(d, force)
    return [
        d[k] * (isotropic_slope * force[i] + dyadic_slope * along * d[i])
        + dyadic * (d[i] * force[k] + (along if i == k else 0.0))
        for i in range(3)
        for k in range(3)
    ]


@register_jitable(inline="always")
def stresslet_of_dyad(
    scalars: Scalars, d: Vector, dyad: Sequence[Number]
) -> tuple[Number, Number, Number]:
    """-T_ijk D_jk/2 = -[a tr(D)/2 + b (d.D.d)/2] d - a D d, of the components of D = w N + N w."""
    linear, cubic = scalars
    turned = (
        dyad[0] * d[0] + dyad[1] * d[1] + dyad[2] * d[2],
        dyad[1] * d[0] + dyad[3] * d[1] + dyad[4] * d[2],
        dyad[2] * d[0] + dyad[4] * d[1] + dyad[5] * d[2],
    )
    along = 0.5 * (linear * (dyad[0] + dyad[3] + dyad[5]) + cubic * dot(turned, d))
    return (
        -(along * d[0] + linear * turned[0]),
        -(along * d[1] + linear * turned[1]),
        -(along * d[2] + linear * turned[2]),
    )


def stresslet(scalars: Scalars, d: Vector, density: Vector, normal: Vector) -> list[Number]:
    """-T_ijk w_j N_k = -[a (w.N) + b (d.w) (d.N)] d - a [w (d.N) + N (d.w)]."""
    linear, cubic = scalars
    through, onto = dot(d, normal), dot(d, density)
    along = linear * dot(density, normal) + cubic * onto * through
    return [-d[i] * along - linear * (density[i] * through + normal[i] * onto) for i in range(3)]


@register_jitable(inline="always")
def stresslet_matrix(
    linear: Number, along: Number, through: Number, d: Vector, normal: Vector
) -> tuple[Number, ...]:
    """Components of -T_ijk N_k = -a [I (d.N) + d N + N d] - b (d.N) d d.

    **Arguments:** `linear`: a; `along`: b (d.N); `through`: d.N.
    """
    onto = (linear * normal[0], linear * normal[1], linear * normal[2])
    trace = linear * through
    x, y, z = along * d[0] + onto[0], along * d[1] + onto[1], along * d[2] + onto[2]
    return (
        -(x * d[0] + onto[0] * d[0] + trace),
        -(x * d[1] + onto[1] * d[0]),
        -(x * d[2] + onto[2] * d[0]),
        -(y * d[1] + onto[1] * d[1] + trace),
        -(y * d[2] + onto[2] * d[1]),
        -(z * d[2] + onto[2] * d[2] + trace),
    )


def stresslet_gradients(
    scalars: Scalars, slopes: Scalars, d: Vector, density: Vector, normal: Vector
) -> tuple[list[Number], list[Number]]:
    """Derivatives of -T_ijk w_j N_k by d, and by N, nine each."""
    (linear, cubic), (linear_slope, cubic_slope) = scalars, slopes
    through, onto, across = dot(d, normal), dot(d, density), dot(density, normal)
    by_d, by_normal = [], []
    for i in range(3):
        dipole = density[i] * through + d[i] * across + normal[i] * onto
        radial = linear_slope * dipole + cubic_slope * d[i] * onto * through
        by_d += [
            -d[k] * radial
            - linear * (density[i] * normal[k] + normal[i] * density[k])
            - cubic * d[i] * (density[k] * through + onto * normal[k])
            - (linear * across + cubic * onto * through if i == k else 0.0)
            for k in range(3)
        ]
        by_normal += [
            -linear * (density[i] * d[k] + d[i] * density[k])
            - cubic * onto * d[i] * d[k]
            - (linear * onto if i == k else 0.0)
            for k in range(3)
        ]
    return by_d, by_normal
