"""Shape disturbances of one azimuthal number, as real orthonormal coefficient vectors.

`azimuthal` has the same fields as amplitudes on the meridian.

Turning a disturbance of an axisymmetric train about the axis multiplies its part of azimuthal
number m by exp(i m angle), so the linear dynamics does not couple different m. With u+- = x +- i y,
number m holds the harmonics (n, m) of z, (n, m + 1) of u+ and (n, m - 1) of u-. Of the two
families that are mirror images of each other the one with z ~ cos(m phi) is kept; the other has
the same dynamics. For m = 0 the second family, the swirl about the axis, is a block of its own.
"""

import numpy as np
from jaxtyping import Float

from celltrain.harmonics.basis import coefficient_index, degrees_and_orders
from celltrain.harmonics.shapes import degree_of

Family = Float[np.ndarray, "member 3 coefficient"]


def _axial(degree: int, m: int) -> Family:
    family = np.zeros((degree - m, 3, degree**2))
    for row, n in enumerate(range(m, degree)):
        family[row, 2, coefficient_index(n, m)] = 1.0
    return family


def _turning(degree: int, order: int, sign: int) -> Family:
    """Vectors x ~ cos(order phi), y ~ sign sin(order phi)."""
    family = np.zeros((max(degree - order, 0), 3, degree**2))
    scale = 1.0 if order == 0 else np.sqrt(0.5)
    for row, n in enumerate(range(order, degree)):
        family[row, 0, coefficient_index(n, order)] = scale
        if order > 0:
            family[row, 1, coefficient_index(n, -order)] = sign * scale
    return family


def _swirling(degree: int) -> Family:
    family = np.zeros((degree - 1, 3, degree**2))
    for row, n in enumerate(range(1, degree)):
        family[row, 0, coefficient_index(n, -1)] = -np.sqrt(0.5)
        family[row, 1, coefficient_index(n, 1)] = np.sqrt(0.5)
    return family


def azimuthal_families(degree: int, m: int) -> tuple[Family, ...]:
    """The families ("z", "u+", "u-") of azimuthal number m >= 0; for m = 0 "u-" is the swirl.

    Joined, they are an orthonormal basis of the disturbances with z ~ cos(m phi). A family that
    has no member below `degree` is empty.
    """
    third = _turning(degree, m - 1, -1) if m else _swirling(degree)
    return _axial(degree, m), _turning(degree, m + 1, 1), third


def azimuthal_basis(degree: int, m: int) -> Float[np.ndarray, "member 3 coefficient"]:
    """Orthonormal basis of the disturbances of azimuthal number m with z ~ cos(m phi)."""
    return np.concatenate(azimuthal_families(degree, m))


def axisymmetric_basis(degree: int) -> Float[np.ndarray, "member 3 coefficient"]:
    """Orthonormal basis of the axisymmetric shapes without swirl; member 0 moves the cell in z."""
    return np.concatenate(azimuthal_families(degree, 0)[:2])


def both_families(degree: int, m: int) -> tuple[Family, ...]:
    """The basis of azimuthal number m, and for m > 0 that with z ~ sin(m phi) in its order.

    The linear dynamics of an axisymmetric train is the same in both.
    """
    basis = azimuthal_basis(degree, m)
    return (basis,) if m == 0 else (basis, _turned_family(basis, m))


def _turned_family(basis: Family, m: int) -> Family:
    """Disturbances turned by pi/(2 m) about the axis, shapes and parameters alike.

    x'(theta, phi) = R x(theta, phi - angle), with R the rotation by the angle.
    """
    angle = np.pi / (2 * m)
    n, order = degrees_and_orders(degree_of(basis))
    partner = n * n + n - order
    # cos(k (phi - a)) = cos(k a) cos(k phi) + sin(k a) sin(k phi), and the like for the sine.
    shifted = np.cos(order * angle) * basis - np.sin(order * angle) * basis[..., partner]
    cosine, sine = np.cos(angle), np.sin(angle)
    rotation = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    return np.einsum("ij,ujk->uik", rotation, shifted)
