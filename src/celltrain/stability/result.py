"""What is known of a train's linear dynamics."""

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from jaxtyping import Complex, Float, Int

from celltrain.harmonics import azimuthal_basis
from celltrain.quantities import Quantity, Record, quantity
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

    growth_rate: Annotated[
        float, Quantity(r"\mathrm{Re} \lambda", "U/r0", "growth rate of the mode")
    ]
    frequency: Annotated[float, Quantity(r"\mathrm{Im} \lambda", "U/r0", "frequency of the mode")]
    azimuthal_number: Annotated[int, Quantity("m", "1", "azimuthal number of the mode")]
    wave_number: Annotated[int, Quantity("j", "1", "wave number of the mode, q = 2 pi j/N")]
    neutral: Annotated[
        bool, Quantity("", "1", "whether a symmetry makes the growth rate of the mode zero")
    ]
    multiplicity: Annotated[
        int, Quantity("", "1", "how many modes of the whole train this one stands for")
    ]
    index: Annotated[int, Quantity("", "1", "place of the mode among the eigenvalues of its block")]
    neutral_kind: Annotated[str, Quantity("", "1", "the symmetry, empty if not neutral")]


@dataclass(frozen=True)
class ErrorBar:
    """How much the eigenvalue of a mode may be wrong, in U/r0 (see `with_error_bars`).

    `by_degree` is its change by four degrees more, `by_rules` that by finer grids, `overlap` how
    well the mode was recognised there (1: the same vector). NaN if it was not.
    """

    mode: Mode
    by_degree: Annotated[float, Quantity("", "U/r0", "what higher degrees leave of the eigenvalue")]
    by_rules: Annotated[float, Quantity("", "U/r0", "change of the eigenvalue by finer rules")]
    overlap: Annotated[
        float, Quantity("", "1", "overlap with the mode in these computations, 1 for the same")
    ]

    @property
    @quantity(Quantity(r"\delta\lambda", "U/r0", "error bar of the eigenvalue"))
    def total(self) -> float:
        """The bar: the eigenvalue lies within this distance, as far as it can be told."""
        return self.by_degree + self.by_rules


@dataclass(frozen=True)
class TransientMode:
    """The disturbance that grows fastest at first (in the paper's norm), Eq. (15)."""

    growth_rate: Annotated[
        float,
        Quantity(r"\eta", "U/r0", "initial growth rate of the disturbance", source="Eq. (15)"),
    ]
    azimuthal_number: Annotated[int, Quantity("m", "1", "azimuthal number of the disturbance")]
    wave_number: Annotated[int, Quantity("j", "1", "wave number of the disturbance")]
    vector: Annotated[
        Complex[np.ndarray, " size"],
        Quantity(
            r"v_\eta", "1", "the disturbance that grows fastest at first", ("row",), bulky=True
        ),
    ]


@dataclass(frozen=True, eq=False)
class Stability(Record):
    """The linear dynamics about a steady train, rates in U/r0.

    Dictionaries are keyed by the azimuthal number m; arrays have one entry for each of the wave
    numbers j = 0 ... N/2. `spectral_abscissa` is the largest growth rate of a mode that is not
    neutral by symmetry, and `error_estimate` its error by `convergence`, the abscissas at several
    degrees (NaN, and none, if that was not asked for). `numerical_abscissas` holds the
    numerical abscissa in every norm offered. `error_bars` are those of the leading modes, if they
    were asked for.
    """

    kind: ClassVar[str] = "stability"
    title: ClassVar[str] = "linear dynamics of a steady train of cells in a tube"

    base: Base
    azimuthal_numbers: Annotated[
        tuple[int, ...], Quantity("m", "1", "azimuthal numbers for which there are blocks")
    ]
    wave_numbers: Annotated[
        Int[np.ndarray, " wave"],
        Quantity("j", "1", "wave numbers along the train", equation=r"q = 2 \pi j/N"),
    ]
    blocks: Annotated[
        dict[int, Complex[np.ndarray, "wave size size"]],
        Quantity(
            "A_m(q)",
            "U/r0",
            "block of the linearised dynamics",
            ("wave", "row", "column"),
            bulky=True,
        ),
    ]
    eigenvalues: Annotated[
        dict[int, Complex[np.ndarray, "wave size"]],
        Quantity(
            r"\lambda",
            "U/r0",
            "eigenvalues of the block",
            ("wave", "eigenvalue"),
            source="Eq. (13)",
            bulky=True,
        ),
    ]
    right_vectors: Annotated[
        dict[int, Complex[np.ndarray, "wave size size"]],
        Quantity(
            "v",
            "1",
            "right eigenvectors of the block, in columns",
            ("wave", "row", "eigenvalue"),
            bulky=True,
        ),
    ]
    left_vectors: Annotated[
        dict[int, Complex[np.ndarray, "wave size size"]],
        Quantity(
            "w",
            "1",
            "left eigenvectors of the block, in columns",
            ("wave", "row", "eigenvalue"),
            bulky=True,
        ),
    ]
    modes: Annotated[
        tuple[Mode, ...],
        Quantity("", "1", "all modes, by falling growth rate", bulky=True),
    ]
    spectral_abscissa: Annotated[
        float,
        Quantity(
            r"\alpha",
            "U/r0",
            "largest growth rate, neutral modes set aside",
            equation=r"\alpha = \max \mathrm{Re} \lambda",
            source="Eq. (14)",
        ),
    ]
    numerical_abscissa: Annotated[
        float,
        Quantity(
            r"\eta",
            "U/r0",
            "largest initial growth rate in the paper's norm",
            source="Eq. (15)",
        ),
    ]
    numerical_abscissas: Annotated[
        dict[str, float], Quantity(r"\eta", "U/r0", "largest initial growth rate in each norm")
    ]
    error_estimate: Annotated[
        float,
        Quantity(
            r"\delta\alpha",
            "U/r0",
            "error of the largest growth rate by what its changes with the degree leave",
        ),
    ]
    convergence: Convergence
    transient: TransientMode
    seconds: Annotated[dict[str, float], Quantity("", "s", "wall time of each stage")]
    error_bars: Annotated[
        tuple[ErrorBar, ...], Quantity("", "U/r0", "error bars of the leading modes")
    ] = ()

    @property
    @quantity(
        Quantity("", "1", "sign of the largest growth rate as far as error bars tell, 0 if not")
    )
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
