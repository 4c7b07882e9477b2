"""What is known of a train's linear dynamics."""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float, Int

from celltrain.harmonics import azimuthal_basis
from celltrain.steady import Base
from celltrain.steady.degree import Convergence


@dataclass(frozen=True)
class Mode:
    """One eigenvalue of the linear dynamics, with its place in a `Stability`.

    `wave_number` is the integer j of q = 2 pi j/N; the mode with -j is the complex conjugate. One
    entry stands for `multiplicity` eigenvalues of the full matrix: twice for the mirror image of a
    mode with azimuthal_number > 0, twice for -j unless that is the same wave. `index` is the column
    in `right_vectors[azimuthal_number][wave_number]`.
    """

    growth_rate: float
    frequency: float
    azimuthal_number: int
    wave_number: int
    neutral: bool
    multiplicity: int
    index: int
    neutral_kind: str


@dataclass(frozen=True)
class ErrorBar:
    """How much the eigenvalue of a mode may be wrong, in U/r0 (see `with_error_bars`).

    `by_degree` is its change by four degrees more, `by_rules` that by finer grids, `overlap` how
    well the mode was recognised there (1: the same vector). Not numbers if it was not.
    """

    mode: Mode
    by_degree: float
    by_rules: float
    overlap: float

    @property
    def total(self) -> float:
        """The bar: the eigenvalue lies within this distance, as far as it can be told."""
        return self.by_degree + self.by_rules


@dataclass(frozen=True)
class TransientMode:
    """The disturbance that grows fastest at first (in the paper's norm), Eq. (15)."""

    growth_rate: float
    azimuthal_number: int
    wave_number: int
    vector: Complex[np.ndarray, " size"]


@dataclass(frozen=True)
class Stability:
    """The linear dynamics about a steady train, rates in U/r0.

    Dictionaries are keyed by the azimuthal number m; arrays have one entry for each of the wave
    numbers j = 0 ... N/2. `spectral_abscissa` is the largest growth rate of a mode that is not
    neutral by symmetry, and `error_estimate` its error by `convergence`, the abscissas at several
    degrees (not a number, and none, if that was not asked for). `numerical_abscissas` holds the
    numerical abscissa in every norm offered. `error_bars` are those of the leading modes, if they
    were asked for.
    """

    base: Base
    azimuthal_numbers: tuple[int, ...]
    wave_numbers: Int[np.ndarray, " wave"]
    blocks: dict[int, Complex[np.ndarray, "wave size size"]]
    eigenvalues: dict[int, Complex[np.ndarray, "wave size"]]
    right_vectors: dict[int, Complex[np.ndarray, "wave size size"]]
    left_vectors: dict[int, Complex[np.ndarray, "wave size size"]]
    modes: tuple[Mode, ...]
    spectral_abscissa: float
    numerical_abscissa: float
    numerical_abscissas: dict[str, float]
    error_estimate: float
    convergence: Convergence
    transient: TransientMode
    seconds: dict[str, float]
    error_bars: tuple[ErrorBar, ...] = ()

    @property
    def growth_sign(self) -> int | None:
        """Sign of the spectral abscissa, as far as the error bars allow one; 0 if they do not.

        1 if a mode with a bar grows by more than its bar, -1 if all such modes decay by more than
        theirs. None without bars.
        """
        if not self.error_bars:
            return None
        if any(bar.mode.growth_rate > bar.total for bar in self.error_bars):
            return 1
        return -1 if all(bar.mode.growth_rate < -bar.total for bar in self.error_bars) else 0

    @property
    def leading(self) -> Mode:
        """The fastest growing mode that is not neutral."""
        return next(mode for mode in self.modes if not mode.neutral)

    def shape(self, mode: Mode, phase: float = 0.0) -> Float[np.ndarray, "cell 3 coefficient"]:
        """A mode as a real disturbance of all N cells' coefficients.

        Its largest cell has coefficients of unit norm; `phase` turns the complex mode in time.
        """
        vector = self.right_vectors[mode.azimuthal_number][mode.wave_number, :, mode.index]
        return self._disturbance(mode.azimuthal_number, mode.wave_number, vector, phase)

    def transient_shape(self, phase: float = 0.0) -> Float[np.ndarray, "cell 3 coefficient"]:
        """The transient disturbance, as `shape` gives a mode."""
        each = self.transient
        return self._disturbance(each.azimuthal_number, each.wave_number, each.vector, phase)

    def _disturbance(
        self, m: int, wave: int, vector: Complex[np.ndarray, " size"], phase: float
    ) -> Float[np.ndarray, "cell 3 coefficient"]:
        cells = self.base.train.cells
        degree = self.base.train.degree
        # A common phase that makes the first cell's disturbance as real as it can be.
        real = vector * np.exp(-0.5j * np.angle(np.sum(vector**2)))
        turn = np.exp(1j * (2.0 * math.pi * wave * np.arange(cells) / cells + phase))
        basis = azimuthal_basis(degree, m)
        shapes = np.einsum("p,u,uik->pik", turn, real, basis).real
        return shapes / np.linalg.norm(shapes, axis=(1, 2)).max()
