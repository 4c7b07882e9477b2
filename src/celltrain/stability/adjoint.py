"""Adjoint modes: what excites a mode, and where its growth rate is made.

The left vectors l of the dynamics, l^H A = lambda l^H, with l^H r = 1, are the adjoint modes in the
inner product of orthonormal coefficients, <l, r> = int conj(l).r dOmega (solid angle of the
membrane's parameters). So

* a disturbance d starts the mode with the amplitude <l, d> (`receptivity`);
* a feedback of strength c, from the displacement at a place of the membrane to the velocity there,
  changes the eigenvalue by no more than c times the structural sensitivity
  |l| |r|/|<l, r>| at that place (Giannetti & Luchini 2007), per unit of solid angle;
* a change dA of the dynamics changes it by l^H dA r, at most |l| |r| |dA|: |l| |r| is the
  eigenvalue's condition number (`condition_number`; Trefethen & Embree 2005, chapter 52).

Disturbances and changes are those that keep the cells' volumes: for the last two, l is freed of its
part along the gradient of the volume, which makes it shorter but gives them the same answers.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from jaxtyping import Complex, Float

from celltrain.harmonics import azimuthal_basis, real_harmonics
from celltrain.parameters import CaseError
from celltrain.quantities import Quantity, Record, quantity
from celltrain.stability.coordinates import normed_block
from celltrain.stability.neutral import neutral_space
from celltrain.stability.norms import Norm, OrthonormalNorm
from celltrain.stability.result import Mode, Stability

Meridian = Float[np.ndarray, " point"]

#: Condition number above which an eigenvalue is called close to a double one; those of trains are 3
#: to 10 otherwise.
NEAR_DOUBLE = 20.0


@dataclass(frozen=True, eq=False)
class StructuralSensitivity(Record):
    """Where on the membrane a mode's eigenvalue is made; a function of theta alone.

    `theta` is the parameter from the front pole to the rear one (radians); `radius` and `axial` the
    place on the steady membrane (r0). `direct` = |r| and `adjoint` = |l| are the sizes of the mode
    that turns about the axis, as exp(i m phi), and of its adjoint; `sensitivity` their product over
    |<l, r>|, per unit of solid angle. Its integral over the sphere is at least 1.
    """

    mode: Mode
    theta: Annotated[
        Meridian, Quantity(r"\theta", "rad", "parameter from the front pole to the rear one")
    ]
    radius: Annotated[Meridian, Quantity("r", "r0", "distance of the membrane from the axis")]
    axial: Annotated[Meridian, Quantity("z", "r0", "axial place of the membrane")]
    direct: Annotated[Meridian, Quantity("|r|", "1", "size of the mode")]
    adjoint: Annotated[Meridian, Quantity("|l|", "1", "size of the adjoint mode")]
    sensitivity: Annotated[
        Meridian,
        Quantity(
            "",
            "1",
            "structural sensitivity per solid angle",
            equation=r"|l| |r|/|\langle l, r\rangle|",
            source="Giannetti & Luchini (2007)",
        ),
    ]

    @property
    @quantity(Quantity("", "1", "integral of the structural sensitivity over the sphere"))
    def integral(self) -> float:
        """Integral of the sensitivity over the sphere: 1 for a normal mode, more otherwise."""
        return float(np.trapezoid(2.0 * np.pi * np.sin(self.theta) * self.sensitivity, self.theta))


def mode_vectors(
    result: Stability, mode: Mode
) -> tuple[Complex[np.ndarray, " size"], Complex[np.ndarray, " size"]]:
    """Left and right vector of a mode, l^H r = 1, in `azimuthal_basis(degree, m)`."""
    m, wave = mode.azimuthal_number, mode.wave_number
    return (
        result.left_vectors[m][wave, :, mode.index],
        result.right_vectors[m][wave, :, mode.index],
    )


def biorthogonality_error(
    left: Complex[np.ndarray, "size mode"], right: Complex[np.ndarray, "size mode"]
) -> float:
    """Largest |l_i^H r_j - delta_ij| relative to |l_i| |r_j|."""
    product = left.conj().T @ right - np.eye(left.shape[1])
    size = np.linalg.norm(left, axis=0)[:, None] * np.linalg.norm(right, axis=0)
    return float(np.abs(product / size).max())


def condition_number(result: Stability, mode: Mode, *, norm: Norm | None = None) -> float:
    """Condition number |l| |r|/|l^H r| >= 1 of the eigenvalue of a mode that is not neutral.

    In the coordinates of a norm (see `coordinates`), that of orthonormal coefficients if none is
    given. Neutral modes are not disturbances there: theirs has no meaning.

    **Raises:** `CaseError` for a neutral mode.
    """
    if mode.neutral:
        raise CaseError(f"mode = {mode.neutral_kind} is not allowed: it is neutral")
    norm = OrthonormalNorm() if norm is None else norm
    m, wave = mode.azimuthal_number, mode.wave_number
    gram = norm.grams(result.base.coefficients, [m])[m]
    block = normed_block(result.blocks[m][wave], gram, neutral_space(result.base, m, wave))
    left, right = mode_vectors(result, mode)
    left, right = block.lift.T @ left, block.reduce @ right
    return float(np.linalg.norm(left) * np.linalg.norm(right) / abs(left.conj() @ right))


def leading_condition(result: Stability) -> float:
    """Condition number of the leading eigenvalue.

    Above `NEAR_DOUBLE` it is close to meeting another one, where an error e of the dynamics becomes
    one of the order of its root, sqrt(e).
    """
    return condition_number(result, result.leading)


def receptivity(
    result: Stability, mode: Mode, disturbance: Float[np.ndarray, "cell 3 coefficient"]
) -> complex:
    """Amplitude of a mode in a disturbance of all cells, <l, d_q> (same unit as the disturbance).

    d_q = (1/N) sum_p d_p exp(-i q p) is the disturbance's wave with the mode's q; of the mode and
    its mirror image (m > 0) the one with z ~ cos(m phi) is meant.
    """
    cells = len(disturbance)
    phase = np.exp(-2j * np.pi * mode.wave_number * np.arange(cells) / cells)
    wave = np.einsum("p,pik->ik", phase, disturbance) / cells
    basis = azimuthal_basis(result.base.train.degree, mode.azimuthal_number)
    left, _ = mode_vectors(result, mode)
    return complex(left.conj() @ np.einsum("uik,ik->u", basis, wave))


def meridian_displacement(
    vector: Complex[np.ndarray, " size"], degree: int, m: int, theta: Meridian
) -> Complex[np.ndarray, "3 point"]:
    """Radial, azimuthal and axial amplitude of a disturbance along a meridian.

    The disturbance is the first and last times cos(m phi), the second times sin(m phi) (1 for m =
    0). With its mirror image, a quarter of a wave behind, it turns about the axis as exp(i m phi)
    and has the same size, the root of the sum of squares, at all phi.
    """
    field = np.einsum("u,uik->ik", vector, azimuthal_basis(degree, m))
    radial, azimuthal, axial = field @ real_harmonics(degree, theta, np.zeros_like(theta)).T
    if m > 0:
        phi = 0.5 * np.pi / m
        x, y, _ = field @ real_harmonics(degree, theta, np.full_like(theta, phi)).T
        azimuthal = y * np.cos(phi) - x * np.sin(phi)
    return np.stack([radial, azimuthal, axial])


def structural_sensitivity(
    result: Stability, mode: Mode, *, points: int = 721
) -> StructuralSensitivity:
    """The structural sensitivity |l| |r|/|<l, r>| of a mode along the meridian of a cell.

    **Raises:** `CaseError` for a neutral mode.
    """
    if mode.neutral:
        raise CaseError(f"mode = {mode.neutral_kind} is not allowed: it is neutral")
    base, m = result.base, mode.azimuthal_number
    degree = base.train.degree
    theta = np.linspace(0.0, np.pi, points)
    left, right = mode_vectors(result, mode)
    volume = neutral_space(base, m, mode.wave_number).volume
    if volume is not None:
        left = left - volume * (volume @ left)
    fields = [meridian_displacement(each, degree, m, theta) for each in (left, right)]
    adjoint, direct = (np.linalg.norm(field, axis=0) for field in fields)
    # A turning disturbance has both mirror images, each with its own <l, r>.
    overlap = abs(left.conj() @ right) * (2.0 if m > 0 else 1.0)
    radius, _, axial = base.coefficients @ real_harmonics(degree, theta, np.zeros_like(theta)).T
    return StructuralSensitivity(
        mode, theta, radius, axial, direct, adjoint, adjoint * direct / overlap
    )
