"""Transient growth: how far disturbances grow before the modes take over.

    G(t) = max |exp(A t) d|/|d|, the largest singular value of exp(B t),                 (a)

B the block in the coordinates of the norm (see `coordinates`: volumes left out, the train's
displacement and the cells' turns about the axis factored out). G(0) = 1, dG/dt(0) = eta, and
G >= exp(alpha t). The right and left singular vectors are the optimal disturbance and what becomes
of it (Trefethen & Embree 2005, chapter 14). Blocks do not couple, and for the norms offered their
disturbances are orthogonal, so the largest G of a train is that of one of its blocks.
"""

from dataclasses import dataclass, replace
from typing import Annotated, ClassVar

import numpy as np
import scipy  # loads its parts when they are used
from jaxtyping import Complex, Float

from celltrain.parameters import CaseError
from celltrain.quantities import Quantity, Record, quantity
from celltrain.stability.coordinates import NormedBlock, normed_blocks
from celltrain.stability.norms import Norm, PaperNorm
from celltrain.stability.result import Stability, TransientMode
from celltrain.steady import Base

# Times from this part of the last one on, in equal ratios.
FIRST_TIME = 1e-4
PEAK_TOLERANCE = 1e-8

Times = Float[np.ndarray, " time"]


@dataclass(frozen=True)
class Peak:
    """The highest local maximum of G(t): growth that passes.

    If G has none, it is G(0) = 1 where G only falls, and with `interior` False the last time where
    it rises to the end.
    """

    time: Annotated[float, Quantity("t", "r0/U", "time of the peak")]
    growth: Annotated[float, Quantity("G", "1", "growth at the peak")]
    interior: Annotated[bool, Quantity("", "1", "whether growth falls again after it")]


@dataclass(frozen=True, eq=False)
class BlockGrowth(Record):
    """Growth of the disturbances of one block; `wave_number` is j of q = 2 pi j/N."""

    azimuthal_number: Annotated[int, Quantity("m", "1", "azimuthal number of the block")]
    wave_number: Annotated[int, Quantity("j", "1", "wave number of the block")]
    growth: Annotated[
        Times,
        Quantity(
            "G(t)",
            "1",
            "largest growth of a disturbance of the block",
            ("times",),
            equation=r"G(t) = \max_d |e^{A t} d|/|d|",
        ),
    ]
    numerical_abscissa: Annotated[
        float, Quantity(r"\eta", "U/r0", "largest initial growth rate of the block")
    ]
    spectral_abscissa: Annotated[
        float, Quantity(r"\alpha", "U/r0", "largest growth rate of the block")
    ]
    peak: Peak


@dataclass(frozen=True, eq=False)
class OptimalDisturbance(Record):
    """The disturbance that has grown most at a time, Eq. (a) of the module.

    `initial` has unit norm, `final` = exp(A t) initial; both in `azimuthal_basis(degree, m)` and
    the smallest among those that differ by neutral displacements.
    """

    azimuthal_number: Annotated[int, Quantity("m", "1", "azimuthal number of the disturbance")]
    wave_number: Annotated[int, Quantity("j", "1", "wave number of the disturbance")]
    time: Annotated[float, Quantity("t", "r0/U", "time at which it has grown most of all")]
    growth: Annotated[float, Quantity("G", "1", "how much it has grown then")]
    initial: Annotated[
        Complex[np.ndarray, " size"],
        Quantity("", "1", "the disturbance at first", ("row",), bulky=True),
    ]
    final: Annotated[
        Complex[np.ndarray, " size"],
        Quantity("", "1", "what has become of it", ("row",), bulky=True),
    ]

    def shapes(
        self, result: Stability
    ) -> tuple[Float[np.ndarray, "cell 3 coefficient"], Float[np.ndarray, "cell 3 coefficient"]]:
        """Initial and final disturbance of all cells of `result`, as `Stability.shape` scales."""
        m, wave = self.azimuthal_number, self.wave_number

        def train(vector: Complex[np.ndarray, " size"]) -> Float[np.ndarray, "cell 3 coefficient"]:
            mode = TransientMode(self.growth, m, wave, vector)
            return replace(result, transient=mode).transient_shape()

        return train(self.initial), train(self.final)


@dataclass(frozen=True, eq=False)
class TransientGrowth(Record):
    """How far disturbances of a train grow, times in r0/U.

    `blocks` holds G(t) of every block; `modal` is |exp(A t) v_alpha| and `abrupt` |exp(A t) v_eta|
    for the leading mode and the disturbance that grows fastest at first, of unit norm. `optimal`
    belongs to the highest interior peak of all blocks; if there is none, to the last time.
    """

    kind: ClassVar[str] = "transient"
    title: ClassVar[str] = "transient growth of disturbances of a steady train"

    result: Annotated[Stability, Quantity("", "1", "the linear dynamics", bulky=True)]
    norm: Annotated[str, Quantity("", "1", "norm in which growth is measured")]
    times: Annotated[Times, Quantity("t", "r0/U", "times", ("times",))]
    blocks: tuple[BlockGrowth, ...]
    modal: Annotated[
        Times,
        Quantity(r"|e^{A t} v_\alpha|", "1", "growth of the leading mode", ("times",)),
    ]
    abrupt: Annotated[
        Times,
        Quantity(
            r"|e^{A t} v_\eta|",
            "1",
            "growth of the disturbance that grows fastest at first",
            ("times",),
        ),
    ]
    optimal: OptimalDisturbance

    @property
    def base(self) -> Base:
        """The steady train."""
        return self.result.base

    @property
    @quantity(Quantity("G(t)", "1", "largest growth of all disturbances", ("times",)))
    def growth(self) -> Times:
        """G(t) of the train: the largest of its blocks'."""
        return np.asarray(np.max([block.growth for block in self.blocks], axis=0))

    @property
    @quantity(Quantity("G", "1", "the largest passing growth"))
    def largest_growth(self) -> float:
        """G at the highest interior peak; if there is none, at the last time."""
        return self.optimal.growth

    @property
    @quantity(Quantity(r"\eta", "U/r0", "initial growth rate"))
    def numerical_abscissa(self) -> float:
        """dG/dt at t = 0, in U/r0."""
        return max(block.numerical_abscissa for block in self.blocks)

    @property
    @quantity(Quantity(r"\alpha", "U/r0", "growth rate for long times"))
    def spectral_abscissa(self) -> float:
        """Growth rate of G as t becomes large, in U/r0."""
        return max(block.spectral_abscissa for block in self.blocks)


def propagator_norm(
    matrix: Complex[np.ndarray, "size size"], times: Float[np.ndarray, " time"]
) -> Float[np.ndarray, " time"]:
    """|exp(B t)|, the largest singular value, at each time."""
    return np.array([np.linalg.norm(scipy.linalg.expm(t * matrix), 2) for t in times])


def growth_peak(
    matrix: Complex[np.ndarray, "size size"],
    times: Float[np.ndarray, " time"],
    growth: Float[np.ndarray, " time"],
) -> Peak:
    """The highest local maximum of |exp(B t)|, by bounded optimisation about the best sample."""
    inside = np.flatnonzero((growth[1:-1] > growth[:-2]) & (growth[1:-1] >= growth[2:])) + 1
    if not inside.size:
        last = len(times) - 1 if growth[-1] > growth[0] else 0
        return Peak(float(times[last]), float(growth[last]), last == 0)
    best = int(inside[np.argmax(growth[inside])])
    found = scipy.optimize.minimize_scalar(
        lambda t: -float(propagator_norm(matrix, np.array([t]))[0]),
        bounds=(times[best - 1], times[best + 1]),
        method="bounded",
        options={"xatol": PEAK_TOLERANCE * times[best]},
    )
    if -found.fun < growth[best]:
        return Peak(float(times[best]), float(growth[best]), True)
    return Peak(float(found.x), float(-found.fun), True)


def optimal_disturbance(
    block: NormedBlock, time: float
) -> tuple[float, Complex[np.ndarray, " size"], Complex[np.ndarray, " size"]]:
    """Largest growth up to a time (r0/U), the disturbance of unit norm that has it, and its fate.

    The fate is exp(A t) times the disturbance, up to neutral displacements.
    """
    left, values, right = np.linalg.svd(scipy.linalg.expm(time * block.matrix))
    # A phase that makes the disturbance as real as it can be.
    initial = block.lift @ right[0].conj()
    turn = np.exp(-0.5j * np.angle(np.sum(initial**2)))
    return float(values[0]), turn * initial, turn * values[0] * (block.lift @ left[:, 0])


def transient_growth(
    result: Stability, *, norm: Norm | None = None, until: float = 10.0, samples: int = 60
) -> TransientGrowth:
    """Transient growth in every block of a train.

        G(t) = max |exp(A t) d|/|d|,     Eq. (a) of the module.

    **Arguments:**

    - `result`: the linear dynamics; all its azimuthal and wave numbers are looked at.
    - `norm`: of disturbances; that of the paper, Eq. (8), if not given.
    - `until`: last time, in r0/U.
    - `samples`: times, 0 and from `until`/10000 on in equal ratios.

    **Returns:** a `TransientGrowth`.

    **Raises:** `CaseError` for times that are not allowed or a norm that is not positive definite.
    """
    if not (np.isfinite(until) and until > 0.0):
        raise CaseError(f"until = {until:g} is not allowed; allowed: a number > 0")
    if samples < 3:
        raise CaseError(f"samples = {samples} is not allowed; allowed: whole numbers >= 3")
    norm = PaperNorm() if norm is None else norm
    times = np.concatenate([[0.0], until * np.geomspace(FIRST_TIME, 1.0, samples - 1)])
    normed = normed_blocks(result, norm)
    blocks = []
    for (m, wave), block in normed.items():
        growth = propagator_norm(block.matrix, times)
        peak = growth_peak(block.matrix, times, growth)
        blocks.append(
            BlockGrowth(m, wave, growth, block.numerical_abscissa, block.spectral_abscissa, peak)
        )
    transient = [each for each in blocks if each.peak.interior and each.peak.time > 0.0]
    best = max(transient or blocks, key=lambda each: each.peak.growth)
    place = (best.azimuthal_number, best.wave_number)
    leading = result.leading
    mode_place = (leading.azimuthal_number, leading.wave_number)
    mode = result.right_vectors[leading.azimuthal_number][leading.wave_number, :, leading.index]
    fastest = max(blocks, key=lambda each: each.numerical_abscissa)
    fast_place = (fastest.azimuthal_number, fastest.wave_number)
    matrix = normed[fast_place].matrix
    abrupt = scipy.linalg.eigh(0.5 * (matrix + matrix.conj().T))[1][:, -1]
    largest, initial, final = optimal_disturbance(normed[place], best.peak.time)
    return TransientGrowth(
        result=result,
        norm=norm.name,
        times=times,
        blocks=tuple(blocks),
        modal=_size(normed[mode_place], normed[mode_place].reduce @ mode, times),
        abrupt=_size(normed[fast_place], abrupt, times),
        optimal=OptimalDisturbance(*place, best.peak.time, largest, initial, final),
    )


def _size(block: NormedBlock, start: Complex[np.ndarray, " reduced"], times: Times) -> Times:
    """|exp(B t) x|/|x|."""
    moved = [np.linalg.norm(scipy.linalg.expm(t * block.matrix) @ start) for t in times]
    return np.asarray(moved) / np.linalg.norm(start)
