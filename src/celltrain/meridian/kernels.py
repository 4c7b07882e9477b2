"""The free-space kernels as fields about targets on the meridian phi = 0.

With d = x - y from the source y to the target x = (rho, 0, z), in mu U r0,

    G_ij = delta_ij/|d| + d_i d_j/|d|^3,
    T_ik = (d G_ij/d x_k) F_j = (-d_k F_i + delta_ik d.F + d_i F_k)/|d|^3 - 3 d_i d_k (d.F)/|d|^5,

and K_ij = -6 r_i r_j (r.n)/|r|^5 with r = -d, n = n dS/dOmega. On an axisymmetric surface each
component is even or odd in the longitude of the source: G and T have nine even fields and six odd
ones, K four and two.
"""

from typing import no_type_check

import numpy as np
from jaxtyping import Float
from numba import njit

#: Places of the fields of `force_fields`: the even ones, then the odd ones.
EVEN = ("Gxx", "Gxz", "Gzz", "Gyy", "Txx", "Txz", "Tzx", "Tzz", "Tyy")
ODD = ("Gxy", "Gyz", "Txy", "Tyx", "Tyz", "Tzy")
#: The same for `stress_fields`.
STRESS_EVEN = ("Kxx", "Kxz", "Kzz", "Kyy")
STRESS_ODD = ("Kxy", "Kyz")

Meridian = Float[np.ndarray, " point"]
Points = Float[np.ndarray, "3 target source"]
Fields = Float[np.ndarray, "field target source"]

_OPTIONS = {"fastmath": True, "cache": True, "error_model": "numpy"}


@njit(**_OPTIONS)
@no_type_check
def force_fields(
    rho: Meridian,
    z: Meridian,
    points: Points,
    forces: Points,
    weights: Meridian,
    even: Fields,
    odd: Fields,
) -> None:
    """Fill the fields of G and T, times the weights of the sources.

    **Arguments:** `rho`, `z` [target]; `points`, `forces` [3, target, source], Cartesian;
    `weights` [source]; `even` [9, target, source], `odd` [6, target, source].
    """
    for t in range(rho.shape[0]):
        for s in range(weights.shape[0]):
            dx = rho[t] - points[0, t, s]
            dy = -points[1, t, s]
            dz = z[t] - points[2, t, s]
            fx, fy, fz = forces[0, t, s], forces[1, t, s], forces[2, t, s]
            inverse_square = 1.0 / (dx * dx + dy * dy + dz * dz)
            one = np.sqrt(inverse_square) * weights[s]
            three = one * inverse_square
            along = (dx * fx + dy * fy + dz * fz) * three
            fx *= three
            fy *= three
            fz *= three
            five = 3.0 * along * inverse_square
            even[0, t, s] = one + dx * dx * three
            even[1, t, s] = dx * dz * three
            even[2, t, s] = one + dz * dz * three
            even[3, t, s] = one + dy * dy * three
            even[4, t, s] = along - dx * dx * five
            even[5, t, s] = dx * fz - dz * fx - five * dx * dz
            even[6, t, s] = dz * fx - dx * fz - five * dx * dz
            even[7, t, s] = along - dz * dz * five
            even[8, t, s] = along - dy * dy * five
            odd[0, t, s] = dx * dy * three
            odd[1, t, s] = dy * dz * three
            odd[2, t, s] = dx * fy - dy * fx - five * dx * dy
            odd[3, t, s] = dy * fx - dx * fy - five * dx * dy
            odd[4, t, s] = dy * fz - dz * fy - five * dy * dz
            odd[5, t, s] = dz * fy - dy * fz - five * dy * dz


@njit(**_OPTIONS)
@no_type_check
def stress_fields(
    rho: Meridian,
    z: Meridian,
    points: Points,
    normals: Points,
    weights: Meridian,
    even: Fields,
    odd: Fields,
) -> None:
    """Fill the fields of K, times the weights of the sources.

    **Arguments:** as `force_fields`, with n dS/dOmega in place of the forces; `even` [4, target,
    source], `odd` [2, target, source].
    """
    for t in range(rho.shape[0]):
        for s in range(weights.shape[0]):
            rx = points[0, t, s] - rho[t]
            ry = points[1, t, s]
            rz = points[2, t, s] - z[t]
            inverse_square = 1.0 / (rx * rx + ry * ry + rz * rz)
            through = rx * normals[0, t, s] + ry * normals[1, t, s] + rz * normals[2, t, s]
            five = through * inverse_square * inverse_square * np.sqrt(inverse_square)
            size = -6.0 * five * weights[s]
            even[0, t, s] = rx * rx * size
            even[1, t, s] = rx * rz * size
            even[2, t, s] = rz * rz * size
            even[3, t, s] = ry * ry * size
            odd[0, t, s] = rx * ry * size
            odd[1, t, s] = ry * rz * size
