"""Growth over time, G(t), of many blocks at once, to be given up at any of them.

Times go by powers of 2, or of its root, so that each propagator is the square of another:
exp(2 t B) = exp(t B)^2. That is a tenth of the work of as many exponentials.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.linalg
from jaxtyping import Complex, Float

from celltrain.stability import PaperNorm, Stability, normed_block
from celltrain.stability.neutral import neutral_space

Times = Float[np.ndarray, " time"]
#: Doublings from the first time to the last one.
DOUBLINGS = 10


@dataclass(frozen=True)
class GrowthCurves:
    """The largest growth of disturbances of each azimuthal number, in the norm of Eq. (8).

    `times` in r0/U, the first of them 0.
    """

    times: Times
    by_number: dict[int, Times]
    numerical_abscissa: float

    @property
    def largest(self) -> Times:
        """G(t) of the train, as far as its azimuthal numbers are known."""
        return np.asarray(np.max(list(self.by_number.values()), axis=0))


def growth_curves(
    result: Stability, *, until: float, check: Callable[[], None], fine: bool = True
) -> GrowthCurves:
    """G(t) of every azimuthal number of a train (see `celltrain.stability.transient`).

    **Arguments:** `until`: last time, r0/U; `check`: called before every block, and may raise;
    `fine`: whether times are in the ratio sqrt(2), or else 2.
    """
    every = 2 if fine else 1
    times = until * 2.0 ** (-np.arange(every * DOUBLINGS + 1)[::-1] / every)
    grams = PaperNorm().grams(result.base.coefficients, result.azimuthal_numbers)
    found, fastest = {}, []
    for m in result.azimuthal_numbers:
        each = []
        for wave, block in zip(result.wave_numbers, result.blocks[m], strict=True):
            check()
            normed = normed_block(block, grams[m], neutral_space(result.base, m, int(wave)))
            each.append(_sizes(normed.matrix, times, every))
            fastest.append(normed.numerical_abscissa)
        found[m] = np.concatenate([[1.0], np.max(each, axis=0)])
    return GrowthCurves(np.concatenate([[0.0], times]), found, max(fastest))


def _sizes(matrix: Complex[np.ndarray, "size size"], times: Times, every: int) -> Times:
    """|exp(t B)|, the largest singular value, at times of which each `every`-th is the double."""
    sizes = np.zeros(times.size)
    for first in range(every):
        propagator = scipy.linalg.expm(times[first] * matrix)
        for place in range(first, times.size, every):
            if place > first:
                propagator = propagator @ propagator
            gram = propagator.conj().T @ propagator
            sizes[place] = np.sqrt(np.linalg.eigvalsh(gram)[-1])
    return sizes
