"""Vector fields of one azimuthal number on an axisymmetric surface, as amplitudes on its meridian.

A field of azimuthal number m has the cylindrical components

    u_r = R(theta) cos(m phi),   u_phi = Phi(theta) sin(m phi),   u_z = Z(theta) cos(m phi)

(for m = 0 the swirl is u_phi = Phi), the real part of u exp(i m phi) with u_r = R, u_phi = -i Phi,
u_z = Z. Then u_x +- i u_y has the orders m +- 1 with the amplitudes R +- Phi, so the members of
`families.azimuthal_basis`, in its order, are

    axial  (n = m, ...):       Z = sqrt(2) P_nm          (P_n0 for m = 0),
    plus   (n = m + 1, ...):   R = Phi = P_n,m+1         (m = 0: R alone, n = 1, ...),
    minus  (n = m - 1, ...):   R = -Phi = P_n,m-1        (m = 0: the swirl, Phi = P_n1, n = 1, ...).

They are orthonormal in int dOmega with the azimuthal factors above.
"""

import numpy as np
from jaxtyping import Float

from celltrain.harmonics.legendre import Table


def cylindrical_members(table: Table, m: int) -> Float[np.ndarray, "3 member point"]:
    """R, Phi and Z of every member of azimuthal number m >= 0.

    **Arguments:** `table`: P_no, or its derivatives, for the orders 0 to m + 1 at least.
    """
    if m == 0:
        axial, radial = table[0], table[1][1:]
        none, empty = np.zeros_like(axial), np.zeros_like(radial)
        return np.stack(
            [
                np.concatenate([none, radial, empty]),
                np.concatenate([none, empty, radial]),
                np.concatenate([axial, empty, empty]),
            ]
        )
    axial, plus, minus = np.sqrt(2.0) * table[m][m:], table[m + 1][m + 1 :], table[m - 1][m - 1 :]
    none = np.zeros_like(axial)
    rest = np.zeros((len(plus) + len(minus), table.shape[2]))
    return np.stack(
        [
            np.concatenate([none, plus, minus]),
            np.concatenate([none, plus, -minus]),
            np.concatenate([axial, rest]),
        ]
    )


def member_count(degree: int, m: int) -> int:
    """How many members of azimuthal number m there are below a degree."""
    if m == 0:
        return 3 * degree - 2
    return max(degree - m, 0) + max(degree - m - 1, 0) + max(degree - m + 1, 0)


def azimuthal_weight(m: int) -> float:
    """The integral over phi of the squares of the azimuthal factors: 2 pi for m = 0, else pi."""
    return 2.0 * np.pi if m == 0 else np.pi
