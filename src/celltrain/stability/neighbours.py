"""What near neighbours do to a train's growth: their coupling removed, Eq. (22).

The blocks A_m(q) are the Fourier transform, along the cells, of the coupling C_p of a cell with the
one p places ahead,

    A_m(q) = sum_p C_p exp(i q p),

p in (-N/2, N/2] with the periodic images of the same cell in each C_p. Removing the neighbours up
to the n-th on both sides (Bryngelson & Freund 2018, section V F) leaves

    A~_m(q) = A_m(q) - sum_(0 < |p| <= n) C_p exp(i q p),

whose spectral abscissa is alpha~(n). A cell's turn about the axis and its volume stay neutral; a
displacement of the whole train does not, since cells then no longer feel all that moves with them.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from jaxtyping import Complex

from celltrain.parameters import CaseError
from celltrain.quantities import Quantity
from celltrain.stability.linearise import Blocks
from celltrain.stability.neutral import NeutralSpace, neutral_space
from celltrain.stability.result import Stability
from celltrain.stability.spectrum import block_spectrum


@dataclass(frozen=True)
class GrowthWithout:
    """Largest growth rate (U/r0) without the `removed` nearest neighbours on each side.

    `azimuthal_number` and `wave_number` (j of q = 2 pi j/N) are those of its mode.
    """

    removed: Annotated[int, Quantity("n", "1", "neighbours removed on each side")]
    spectral_abscissa: Annotated[
        float,
        Quantity(
            r"\tilde\alpha(n)",
            "U/r0",
            "largest growth rate without them",
            source="Eq. (22)",
        ),
    ]
    azimuthal_number: Annotated[int, Quantity("m", "1", "azimuthal number of its mode")]
    wave_number: Annotated[int, Quantity("j", "1", "wave number of its mode")]


def couplings(
    blocks: Complex[np.ndarray, "wave size size"], cells: int
) -> Complex[np.ndarray, "cell size size"]:
    """C_p for p = 0 ... N - 1 (p and p - N are the same), from A_m(q) for j = 0 ... N/2."""
    mirrored = blocks[1 : (cells + 1) // 2].conj()[::-1]
    return np.fft.fft(np.concatenate([blocks, mirrored]), axis=0) / cells


def blocks_without_neighbours(result: Stability, removed: int) -> Blocks:
    """The blocks without the coupling of the `removed` nearest neighbours on each side.

    **Raises:** `CaseError` for a number of neighbours that the train does not have.
    """
    cells = result.base.train.cells
    if not 0 <= removed <= cells // 2:
        raise CaseError(
            f"removed = {removed} is not allowed; allowed: 0 to {cells // 2}, the neighbours on"
            " each side of a cell"
        )
    number = np.arange(cells)
    apart = np.minimum(number, cells - number)
    kept = (apart == 0) | (apart > removed)
    waves = np.exp(2j * np.pi * np.outer(result.wave_numbers, number) / cells)
    return {
        m: np.einsum("jp,puv->juv", waves[:, kept], couplings(blocks, cells)[kept])
        for m, blocks in result.blocks.items()
    }


def growth_without_neighbours(result: Stability, removed: int) -> GrowthWithout:
    """alpha~(n) = max Re lambda, lambda the eigenvalues of A~_m(q) of Eq. (22) (see the module).

    **Raises:** `CaseError` for a number of neighbours that the train does not have.
    """
    found = []
    for m, blocks in blocks_without_neighbours(result, removed).items():
        for wave, block in zip(result.wave_numbers, blocks, strict=True):
            neutral = neutral_space(result.base, m, int(wave))
            spectrum = block_spectrum(block, _still_neutral(neutral) if removed else neutral)
            rates = [
                value.real
                for value, kind in zip(spectrum.eigenvalues, spectrum.kinds, strict=True)
                if not kind
            ]
            found.append(GrowthWithout(removed, float(max(rates)), m, int(wave)))
    return max(found, key=lambda each: each.spectral_abscissa)


def _still_neutral(neutral: NeutralSpace) -> NeutralSpace:
    """Without the displacement of the whole train."""
    stays = [place for place, kind in enumerate(neutral.kinds) if kind != "translation"]
    kinds = tuple(neutral.kinds[place] for place in stays)
    return NeutralSpace(neutral.right[:, stays], kinds, neutral.volume)
