"""The exact linear dynamics of a steady train, block by block.

A disturbance of the train's cells by exp(i q p), p the number of the cell, and of azimuthal number
m keeps its form: d' = A d falls apart into one small matrix A_m(q) for each m and q, assembled on
the meridian (see `meridian.train`). For a viscosity ratio lam other than 1, with B of
`meridian.double_layer`,

    A_m(q; lam) = B_m(q)^-1 A_m(q; 1).
"""

from collections.abc import Callable, Sequence

import numpy as np
from jaxtyping import Complex

from celltrain.meridian.double_layer import DoubleLayer
from celltrain.meridian.rules import Rules
from celltrain.meridian.train import SMALLEST_PHASE, TrainFlow
from celltrain.steady import Base
from celltrain.steady.problem import SteadyProblem

Blocks = dict[int, Complex[np.ndarray, "phase member member"]]
#: Called with how much is done, and how much there is.
Progress = Callable[[int, int], None]


class LinearDynamics:
    """The blocks of one steady train, made as they are asked for.

    **Arguments:** `largest_azimuthal_number` that will be asked for; `smallest_phase`: smallest
    q > 0 (radians); `rules`: those of the shape if not given.
    """

    def __init__(
        self,
        base: Base,
        *,
        largest_azimuthal_number: int,
        smallest_phase: float = SMALLEST_PHASE,
        rules: Rules | None = None,
    ) -> None:
        problem = SteadyProblem(base.train)
        self.base = base
        self._ratio = base.train.flow.viscosity_ratio
        self._flow = TrainFlow(
            problem.membrane,
            base.profile,
            radius=base.train.radius,
            period=base.train.period,
            rules=problem.rules(base.profile) if rules is None else rules,
            largest_azimuthal_number=largest_azimuthal_number,
            smallest_phase=smallest_phase,
        )
        self._layer = None if self._ratio == 1.0 else DoubleLayer(self._flow)

    def blocks(
        self, m: int, phases: Sequence[float] | np.ndarray
    ) -> Complex[np.ndarray, "phase member member"]:
        """A_m(q) for phases q in radians per cell, in `azimuthal_basis(degree, m)`, U/r0."""
        phases = [float(q) for q in phases]
        found = self._flow.blocks(m, phases)
        for place, q in enumerate(phases):
            if q == 0.0 or q == np.pi:
                # Of waves that are their own mirror images the dynamics is real.
                found[place].imag = 0.0
        if self._layer is None:
            return found
        return np.linalg.solve(self._layer.equation(m, phases, self._ratio), found)

    def coupling(
        self, m: int, phases: Sequence[float] | np.ndarray
    ) -> Complex[np.ndarray, "phase member member"]:
        """The part of K_m(q) that does not come from a cell's own surface in free space.

        Of cells whose viscosity differs from the plasma's; in the basis of the blocks.
        """
        assert self._layer is not None
        return self._layer.blocks_of_others(m, [float(q) for q in phases])


def smallest(phases: Sequence[float] | np.ndarray) -> float:
    """The smallest phase q > 0 that the sums over images have to serve."""
    return min([*(abs(float(q)) for q in phases if q != 0.0), SMALLEST_PHASE])


def linear_blocks(
    base: Base,
    phases: Sequence[float] | np.ndarray,
    azimuthal_numbers: Sequence[int],
    *,
    rules: Rules | None = None,
    progress: Progress | None = None,
) -> Blocks:
    """Matrices A_m(q) of the linear dynamics about a steady train, in U/r0.

    **Arguments:**

    - `phases`: q, in radians per cell.
    - `azimuthal_numbers`: m >= 0, at most the degree; -m has the same matrix.
    - `rules`: those of the shape if not given.
    - `progress`: called with (azimuthal numbers done, all).

    **Returns:** for each m the matrices in the basis `azimuthal_basis(degree, m)`, one per q. The
    column of a disturbance holds its rate of change; `A_m(-q)` is the complex conjugate of
    `A_m(q)`.
    """
    dynamics = LinearDynamics(
        base,
        largest_azimuthal_number=max(azimuthal_numbers),
        smallest_phase=smallest(phases),
        rules=rules,
    )
    found: Blocks = {}
    for done, m in enumerate(azimuthal_numbers, 1):
        found[m] = dynamics.blocks(m, phases)
        if progress is not None:
            progress(done, len(azimuthal_numbers))
    return found
