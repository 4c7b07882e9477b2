"""From moments of kernel fields to matrices from members to velocities.

A kernel acts on the members of an azimuthal number through the moments of its fields,

    C_ij(o, n) = sum K_ij P_no cos(o phi')  (even fields),   S_ij(o, n) the same with sin (odd),

over the sources. With a field's amplitudes as in `harmonics.azimuthal`, the velocity at phi = 0 is

    plus  (o = m + 1):  R: Cxx + Sxy,   Phi: Cyy - Syx,    Z: Czx + Szy,
    minus (o = m - 1):  R: Cxx - Sxy,   Phi: -Syx - Cyy,   Z: Czx - Szy,
    axial (o = m):      sqrt(2) (Cxz, -Syz, Czz),

and for m = 0: axial (Cxz, 0, Czz), radial (Cxx + Sxy, 0, Czx + Szy), swirl (0, Cyy - Syx, 0).
"""

from collections.abc import Callable

import numpy as np
from jaxtyping import Float

from celltrain.harmonics.azimuthal import member_count

#: Moments of even or odd fields for one order, by field, target and degree.
Moments = Float[np.ndarray, "_ target degree"]
#: Velocity amplitudes R, Phi, Z at the targets for each member.
MemberMatrix = Float[np.ndarray, "target 3 member"]

#: Places of xx, xz, zz, yy, zx among the even fields and of xy, yx, yz, zy among the odd ones.
SINGLE = ((0, 1, 2, 3, 1), (0, 0, 1, 1))
SLOPE = ((4, 5, 7, 8, 6), (2, 3, 4, 5))
STRESS = ((0, 1, 2, 3, 1), (0, 0, 1, 1))


def member_matrix(
    moments: Callable[[int], tuple[Moments, Moments]],
    places: tuple[tuple[int, ...], tuple[int, ...]],
    m: int,
) -> MemberMatrix:
    """The matrix of one kernel for the members of azimuthal number m.

    **Arguments:** `moments`: from an order to the moments of the even and the odd fields; `places`:
    where the kernel's components are among them, such as `SINGLE`.
    """
    of_even, of_odd = places

    def components(order: int) -> tuple[np.ndarray, ...]:
        even, odd = moments(order)
        return tuple(even[i] for i in of_even) + tuple(odd[i] for i in of_odd)

    xx, xz, zz, yy, zx, xy, yx, yz, zy = components(m)
    targets, degree = xx.shape
    found = np.zeros((targets, 3, member_count(degree, m)))
    if m == 0:
        found[:, 0, :degree], found[:, 2, :degree] = xz, zz
        xx, xz, zz, yy, zx, xy, yx, yz, zy = components(1)
        radial, swirl = slice(degree, 2 * degree - 1), slice(2 * degree - 1, None)
        found[:, 0, radial], found[:, 2, radial] = (xx + xy)[:, 1:], (zx + zy)[:, 1:]
        found[:, 1, swirl] = (yy - yx)[:, 1:]
        return found
    axial = max(degree - m, 0)
    plus = slice(axial, axial + max(degree - m - 1, 0))
    minus = slice(plus.stop, None)
    for component, values in enumerate((xz, -yz, zz)):
        found[:, component, :axial] = np.sqrt(2.0) * values[:, m:]
    if m + 1 < degree:
        xx, xz, zz, yy, zx, xy, yx, yz, zy = components(m + 1)
        for component, values in enumerate((xx + xy, yy - yx, zx + zy)):
            found[:, component, plus] = values[:, m + 1 :]
    xx, xz, zz, yy, zx, xy, yx, yz, zy = components(m - 1)
    for component, values in enumerate((xx - xy, -yx - yy, zx - zy)):
        found[:, component, minus] = values[:, m - 1 :]
    return found
