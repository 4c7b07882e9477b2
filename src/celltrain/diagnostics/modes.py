"""How the cells turn in a small disturbance of a steady train (Fig. 14).

A disturbance of azimuthal number 1 that moves the points of an axisymmetric cell at the rates
(R cos(phi), Phi sin(phi), Z cos(phi)) turns it about y. With dS = J dtheta dphi, the centroid c of
its volume moving at c', and A, M those of `moments`,

    A M'_xz = int [(v_x - c'_x)(z - c_z) + x v_z] dS + int x (z - c_z) dS',
    omega_y = M'_xz/(M_zz - M_xx),                                              Eqs. (17)-(19)
    A (M_xx + M_zz) Omega_y = int [(z - c_z)(v_x - c'_x) - x v_z] dS.           Eqs. (20), (21)

For azimuthal number 0 cells may turn about the tube's axis, their axis of symmetry, and for those
above 1 nothing turns.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from celltrain.diagnostics.spectrum import disturbance_amplitude
from celltrain.harmonics import Profile, azimuthal_basis, cylindrical_members
from celltrain.membrane import AxisymmetricMembrane, meridian_membrane
from celltrain.stability import Mode, Stability, TransientMode

#: Difference of two eigenvalues, over the sum of all three, below which they count as equal: axes
#: that differ in length by less than some tenths of a percent.
COINCIDENT = 1e-3

Vector = Complex[np.ndarray, " member"]


@dataclass(frozen=True)
class ModeMotion:
    """Rotation rates of a disturbance for each unit of its amplitude.

    `tumbling` |omega| and `tank_treading` |Omega - omega|, Eqs. (17)-(21), in U/r0^2: root mean
    squares over cells and phases, over the norm of Eq. (8) for one cell, eps/sqrt(N).
    """

    tumbling: float
    tank_treading: float


def mode_motion(result: Stability, mode: Mode | TransientMode) -> ModeMotion:
    """Tumbling and tank-treading of a small disturbance at time 0, as in Fig. 14.

        tumbling = <|omega|^2>^(1/2)/(eps/sqrt(N)),
        tank-treading = <|Omega - omega|^2>^(1/2)/(eps/sqrt(N)),

    omega the rotation of the cell's axes, Eq. (19), Omega that of the membrane, Eq. (20).
    The steady train does not turn, so to first order in the disturbance d the rotations are those
    of the steady cell whose points move at the rates A d: exact, without a finite amplitude.
    Turning about the tube's axis counts as tumbling.
    """
    m, vector = mode.azimuthal_number, _vector(result, mode)
    basis = azimuthal_basis(result.base.train.degree, m)
    # A complex d stands for Re(d exp(i phase)) of each cell: both mean squares have a factor 1/2.
    norm = np.hypot(
        disturbance_amplitude(np.tensordot(vector.real, basis, axes=1)[None]),
        disturbance_amplitude(np.tensordot(vector.imag, basis, axes=1)[None]),
    )
    rates = result.blocks[m][mode.wave_number] @ vector
    axes, membrane = rotations(meridian_membrane(result.base.train), result.base.profile, m, rates)
    return ModeMotion(
        tumbling=float(abs(axes) / norm), tank_treading=float(abs(membrane - axes) / norm)
    )


def rotations(
    membrane: AxisymmetricMembrane, profile: Profile, m: int, rates: Vector
) -> tuple[complex, complex]:
    """omega and Omega of an axisymmetric cell whose members of azimuthal number m change, in U/r0.

    About y for m = 1, about z for m = 0, none otherwise. Where two eigenvalues of the shell tensor
    are nearly equal omega is Omega (see `rotation`).
    """
    if m > 1:
        return 0j, 0j
    points = membrane.meridian
    rho, rho_1, _, z, z_1, _ = points.profile(profile)
    tables, weights = points.legendre(m + 1), points.weights
    radial, around, axial = _fields(tables.value, m, rates)
    length = np.hypot(rho_1, z_1)
    area = weights * rho * length
    if m == 0:
        spin = complex((area * rho) @ around / ((area * rho) @ rho))
        return spin, spin
    radial_1, _, axial_1 = _fields(tables.slope, m, rates)
    stretch = weights * (
        rho * (rho_1 * radial_1 + z_1 * axial_1) / length + length * (radial + around)
    )
    # Of dtheta dphi/(2 pi), as are all integrals here.
    volume = membrane.volume(profile) / (2.0 * np.pi)
    outward = weights * rho * (rho_1 * axial - z_1 * radial)
    drift = 0.5 * (rho @ outward) / volume
    height = z - 0.5 * (weights * rho_1 * rho * z) @ z / volume
    across, along = area @ rho**2 / 2.0, area @ height**2
    forward = (area * height) @ (0.5 * (radial - around) - drift)
    upward = 0.5 * (area * rho) @ axial
    spin = (forward - upward) / (across + along)
    scale = 2.0 * across + along
    spread = (along - across) / scale
    turned = (forward + upward + 0.5 * (rho * height) @ stretch) / scale
    axes = (spread**3 * turned + COINCIDENT**4 * spin) / (spread**4 + COINCIDENT**4)
    return complex(axes), complex(spin)


def _fields(
    table: Float[np.ndarray, "order degree point"], m: int, rates: Vector
) -> Complex[np.ndarray, "3 point"]:
    return np.einsum("cup,u->cp", cylindrical_members(table, m), rates)


def _vector(result: Stability, mode: Mode | TransientMode) -> Vector:
    if isinstance(mode, TransientMode):
        return mode.vector
    return result.right_vectors[mode.azimuthal_number][mode.wave_number, :, mode.index]
