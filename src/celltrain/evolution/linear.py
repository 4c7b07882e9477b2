"""What the linear dynamics predicts for a disturbance: |exp(A t) d|, as eps and as eps_x."""

import math
from dataclasses import dataclass

import numpy as np
import scipy.linalg
from jaxtyping import Complex, Float

from celltrain.harmonics import UNIT_DISPLACEMENT, both_families, degree_of
from celltrain.stability import Stability, paper_weights

# Part of a disturbance's square norm that may lie outside the azimuthal numbers that are known.
NEGLIGIBLE = 1e-9


@dataclass(frozen=True)
class Part:
    """A disturbance's part of one azimuthal number, family and wave number.

    `weight` and `weight_x` are the Gram matrices of eps and of eps_x, times 1/N, and 2/N where -j
    is counted with j.
    """

    block: Complex[np.ndarray, "size size"]
    vector: Complex[np.ndarray, " size"]
    weight: Float[np.ndarray, "size size"]
    weight_x: Float[np.ndarray, "size size"]


@dataclass(frozen=True)
class LinearPrediction:
    """The linear evolution of one disturbance of a train.

    Empty if the stability result lacks azimuthal numbers that the disturbance holds.
    """

    parts: tuple[Part, ...]

    def eps(self, time: float) -> float:
        """Amplitude (Eq. 8, r0) at a time in r0/U after the beginning; nan if not known."""
        return float(self.sizes(np.array([float(time)]))[0][0])

    def sizes(
        self, times: Float[np.ndarray, " time"]
    ) -> tuple[Float[np.ndarray, " time"], Float[np.ndarray, " time"]]:
        """eps (Eq. 8) and eps_x (Fig. 11, root of the sum over the cells), r0, at rising times."""
        squares = np.zeros((2, len(times)))
        for part in self.parts:
            vector, last, step, propagator = part.vector, 0.0, math.nan, part.block
            for index, time in enumerate(times):
                if time - last != step:
                    step = time - last
                    propagator = scipy.linalg.expm(step * part.block)
                vector, last = propagator @ vector, time
                for row, weight in enumerate((part.weight, part.weight_x)):
                    squares[row, index] += float((vector.conj() @ weight @ vector).real)
        eps, eps_x = np.sqrt(squares) if self.parts else np.full(squares.shape, np.nan)
        return eps, eps_x


def linear_prediction(
    result: Stability, disturbance: Float[np.ndarray, "cell 3 coefficient"]
) -> LinearPrediction:
    """The parts d_m(q) of a disturbance, each of which evolves by its own block A_m(q).

    Cells are transformed to waves exp(i q p). For m > 0 disturbances with z ~ cos(m phi) and their
    turn about the axis by pi/(2 m), z ~ sin(m phi), have the same block.
    """
    cells, _, count = disturbance.shape
    degree = degree_of(disturbance)
    weights = paper_weights(degree)
    mean = np.full(count, 1.0 / UNIT_DISPLACEMENT**2)
    total = float(np.sum(weights * disturbance**2))
    waves = np.fft.fft(disturbance, axis=0)
    parts: list[Part] = []
    covered = 0.0
    for m in result.azimuthal_numbers:
        for family in both_families(degree, m):
            gram, gram_x = (
                np.tensordot(family * each, family, axes=((1, 2), (1, 2)))
                for each in (weights, mean)
            )
            for wave in result.wave_numbers:
                vector = np.einsum("uik,ik->u", family, waves[wave])
                copies = 1 if wave == 0 or 2 * wave == cells else 2
                weight = gram * (copies / cells)
                share = float((vector.conj() @ weight @ vector).real)
                covered += share
                if share > 1e-3 * NEGLIGIBLE * total:
                    weight_x = gram_x * (copies / cells)
                    parts.append(Part(result.blocks[m][wave], vector, weight, weight_x))
    return LinearPrediction(tuple(parts) if covered > (1.0 - NEGLIGIBLE) * total else ())
