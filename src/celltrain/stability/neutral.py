"""The modes that symmetries make neutral, and how they are deflated exactly.

What cannot grow or decay is known beforehand:

* each cell's rotation about the axis, a right null vector r of A_0(q) for every q;
* each cell's volume: its gradient n is a left null vector of A_0(q) for every q, and the matching
  right vector is the change of the steady train with its volume;
* the displacement t of the whole train along the tube, a right null vector of A_0(0).

The symmetries are those of the flow. The discrete dynamics has them up to its error: A r, A t and
n^H A are not zero but small (`neutral_defects`). They are deflated: with R = (r, t), the dynamics

    A' = (I - n n^H) A (I - R R^H)

has the null vectors exactly, and on disturbances without volume, modulo R, it is A.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from celltrain.harmonics import member_count
from celltrain.meridian.geometry import volume_gradient
from celltrain.stability.result import Stability
from celltrain.steady import Base

Block = Complex[np.ndarray, "size size"]


@dataclass(frozen=True)
class NeutralSpace:
    """Known null vectors of one block: orthonormal right ones, with their names, and the volume."""

    right: Float[np.ndarray, "size count"]
    kinds: tuple[str, ...]
    volume: Float[np.ndarray, " size"] | None

    @property
    def count(self) -> int:
        """Number of neutral modes."""
        return len(self.kinds) + (self.volume is not None)


@dataclass(frozen=True)
class NeutralDefect:
    """How far the discrete dynamics is from a symmetry, before deflation, in U/r0.

    `raw` is the Rayleigh quotient of the symmetry's unit vector w in A, the eigenvalue that would
    be reported without deflation; `residual` is |A w| ("rotation", "translation") or |w^H A|
    ("volume"). Both are errors of the discretisation. `wave_number` is j of q = 2 pi j/N.
    """

    kind: str
    azimuthal_number: int
    wave_number: int
    raw: complex
    residual: float


def neutral_space(base: Base, m: int, wave: int) -> NeutralSpace:
    """The known null vectors of A_m(2 pi wave/N), in `azimuthal_basis(degree, m)`."""
    degree = base.train.degree
    size = member_count(degree, m)
    if m != 0:
        return NeutralSpace(np.zeros((size, 0)), (), None)
    # A turn about the axis moves a point by its distance from it.
    turned = np.concatenate([np.zeros(2 * degree - 1), base.profile[1, 1:]])
    right = [_unit(turned)]
    kinds = ["rotation"]
    if wave == 0:
        right.append(np.eye(size)[0])
        kinds.append("translation")
    volume = _unit(volume_gradient(base.profile))
    return NeutralSpace(np.stack(right, axis=1), tuple(kinds), volume)


def deflated(block: Block, neutral: NeutralSpace) -> Block:
    """A' of the module: a block with its neutral modes deflated."""
    right, volume = neutral.right, neutral.volume
    block = block - block @ right @ right.T
    return block if volume is None else block - np.outer(volume, volume @ block)


def neutral_defects(result: Stability) -> tuple[NeutralDefect, ...]:
    """What the discrete dynamics of a train makes of its symmetries, one entry per neutral mode."""
    if 0 not in result.azimuthal_numbers:
        return ()
    found = []
    for wave, block in zip(result.wave_numbers, result.blocks[0], strict=True):
        j = int(wave)
        neutral = neutral_space(result.base, 0, j)
        for kind, vector in zip(neutral.kinds, neutral.right.T, strict=True):
            moved = block @ vector
            found.append(_defect(kind, j, vector, moved))
        if neutral.volume is not None:
            found.append(_defect("volume", j, neutral.volume, neutral.volume @ block))
    return tuple(found)


def _defect(
    kind: str, wave: int, vector: Float[np.ndarray, " size"], moved: Complex[np.ndarray, " size"]
) -> NeutralDefect:
    return NeutralDefect(kind, 0, wave, complex(vector @ moved), float(np.linalg.norm(moved)))


def _unit(vector: Float[np.ndarray, " size"]) -> Float[np.ndarray, " size"]:
    return vector / np.linalg.norm(vector)
