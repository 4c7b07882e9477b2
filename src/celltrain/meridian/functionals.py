"""How a functional of a membrane's forces changes as the membrane is displaced.

Outside of the cells' own surfaces a velocity is a sum of functionals

    int l(y).F dOmega,     l(y) = (l_R, l_Phi, l_Z)(r, z) in the amplitudes of azimuthal number m,

of places y and forces F. A displacement (R, Phi, Z) of the sources changes l(y).F, F = (F_r, 0,
F_z) axisymmetric, by

    R:    F_r dl_R/dr + F_z dl_Z/dr,
    Phi:  -(1/r) [F_r (m l_R + l_Phi) + m F_z l_Z],
    Z:    F_r dl_R/dz + F_z dl_Z/dz.

The same with the area vector n in place of F is n_j u_k d_k l_j, a part of the double layer,

    int [(n_j u_k + u_j n_k) d_k l_j - p u.n] dOmega,

p the pressure of the flow l (mu = 1). Arrays are [..., 3, point].
"""

import numpy as np
from jaxtyping import Float

Rows = Float[np.ndarray, "*kind 3 point"]


def moved(
    value: Rows,
    radial_slope: Rows,
    axial_slope: Rows,
    m: int,
    radius: Float[np.ndarray, " point"],
    force: tuple[Float[np.ndarray, " point"], Float[np.ndarray, " point"]],
) -> Rows:
    """Derivative of l(y).F by the place of the sources.

    **Arguments:** l and its slopes in r and z; `radius` of the points; `force`: its axial and
    radial component there.
    """
    axial, radial = force
    found = np.empty_like(value)
    found[..., 0, :] = radial * radial_slope[..., 0, :] + axial * radial_slope[..., 2, :]
    around = radial * (m * value[..., 0, :] + value[..., 1, :]) + m * axial * value[..., 2, :]
    found[..., 1, :] = -around / radius
    found[..., 2, :] = radial * axial_slope[..., 0, :] + axial * axial_slope[..., 2, :]
    return found


def stressed(
    value: Rows,
    radial_slope: Rows,
    axial_slope: Rows,
    pressure: Float[np.ndarray, "*kind point"],
    m: int,
    radius: Float[np.ndarray, " point"],
    area: tuple[Float[np.ndarray, " point"], Float[np.ndarray, " point"]],
) -> Rows:
    """The functional of the double layer whose velocity is l.

    **Arguments:** as `moved`, with the axial and radial component of n dS/dOmega.
    """
    axial, radial = area
    found = moved(value, radial_slope, axial_slope, m, radius, area)
    found += radial * radial_slope + axial * axial_slope
    found[..., 0, :] -= pressure * radial
    found[..., 2, :] -= pressure * axial
    return found
