"""A norm of disturbances by the strain that they put on the membrane.

The energy's second variation at the steady train is no norm. It vanishes for translations; and as
the steady membrane is under stress, it is not zero for turns, though these change no energy, and
its sign is not known in general (`second_variation`; for a turn w it is the work F.(w x (w x x)) of
the membrane's force F). So the norm takes the stiffness without the stress:

    |d|^2 = H(d, d)/(Es S) + w <|P d|^2>,

H the second variation of the energy of a membrane with the same moduli whose resting shape is the
steady one, S its area. H >= 0 since that energy is least there, and H(d, d) = 0 exactly for rigid
motions. These cost no energy but do disturb the train, which is why they are counted by their mean
square displacement <.> over the area, P d being the rigid part of d in the sense of least mean
squares. Without the second term a rigid displacement would grow infinitely many times as it
deforms the cell; so growth in this norm depends on the weight w: state it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg
from jaxtyping import Float

from celltrain.harmonics import Shape, azimuthal_basis, degree_of, profile_of
from celltrain.laws import ElasticBending, MomentBending
from celltrain.membrane import AxisymmetricMembrane, axisymmetric_membrane, cell_material
from celltrain.parameters import CaseError, Train
from celltrain.stability.norms import Grams, Norm, SurfaceNorm


def second_variation(
    membrane: AxisymmetricMembrane, shape: Shape, azimuthal_numbers: Sequence[int]
) -> Grams:
    """d^2 E/ds^2 of the energy of one axisymmetric cell, in mu U, for each azimuthal number m.

    In `azimuthal_basis(degree, m)`. Positive semidefinite where the membrane is free of stress, in
    general indefinite.

    **Raises:** `CaseError` for bending moments, which have no energy.
    """
    if isinstance(membrane.bending, MomentBending):
        raise CaseError(
            "a law of moments has no energy: not allowed for its second variation; allowed"
            " there: bending = 'elastic', 'helfrich'"
        )
    energy = membrane.second_order(profile_of(shape))
    return {m: membrane.hessian(energy, m) for m in azimuthal_numbers}


def rigid_motions(shape: Shape, m: int) -> Float[np.ndarray, "size count"]:
    """Translations and rotations of a cell with azimuthal number m, as columns (m = 0, 1: two).

    In `azimuthal_basis(degree, m)`, of unit coefficient norm, not orthogonal; for m = 0 those along
    and about the axis, for m = 1 those across it and the tilt.
    """
    basis = azimuthal_basis(degree_of(shape), m)
    moved = np.zeros((2, *shape.shape))
    if m == 0:
        moved[0, 2, 0] = 1.0
        moved[1] = np.stack([-shape[1], shape[0], np.zeros_like(shape[0])])
    elif m == 1:
        moved[0, 0, 0] = 1.0
        moved[1] = np.stack([shape[2], np.zeros_like(shape[0]), -shape[0]])
    else:
        return np.zeros((len(basis), 0))
    columns = np.einsum("uik,cik->uc", basis, moved)
    return columns / np.linalg.norm(columns, axis=0)


@dataclass(frozen=True)
class StrainNorm(Norm):
    """Strain energy of a disturbance and mean square of its rigid part (see the module).

    `rigid_weight` is w > 0.
    """

    train: Train
    rigid_weight: float = 1.0
    name: str = "strain"

    def __post_init__(self) -> None:
        if not self.rigid_weight > 0.0:
            raise CaseError(f"rigid_weight = {self.rigid_weight:g} is not allowed; allowed: > 0")

    def grams(self, shape: Shape, azimuthal_numbers: Sequence[int]) -> Grams:
        """Dense matrices."""
        cell = self.train.cell
        law, _ = cell_material(cell)
        at_rest = axisymmetric_membrane(
            law,
            # Elastic whatever the cell's: of the others a steady shape is no minimum.
            ElasticBending(cell.bending_modulus),
            profile_of(shape),
            energy_order=self.train.sizes.energy_order,
        )
        area = at_rest.area(profile_of(shape))
        stiffness = second_variation(at_rest, shape, azimuthal_numbers)
        surface = SurfaceNorm().grams(shape, azimuthal_numbers)
        grams = {}
        for m, gram in stiffness.items():
            along = surface[m] @ rigid_motions(shape, m)
            rigid = np.zeros_like(gram)
            if along.shape[1]:
                inner = rigid_motions(shape, m).T @ along
                rigid = along @ scipy.linalg.solve(inner, along.T, assume_a="pos")
            grams[m] = gram / (cell.shear_modulus * area) + self.rigid_weight * rigid
        return grams
