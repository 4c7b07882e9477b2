"""Pseudospectra and the Kreiss constant of a block of the linear dynamics.

The eps-pseudospectrum is where |(z - B)^-1| > 1/eps: all eigenvalues that a change of the dynamics
by less than eps can give it. |(z - B)^-1| is one over the smallest singular value of z - B, which
is that of z - T, T the triangular Schur form of B (Trefethen & Embree 2005, chapters 2 and 39). B
is the block in the coordinates of a norm, without the neutral modes (see `coordinates`).

With the growth of the leading mode taken out, B - alpha, the Kreiss constant

    K = sup (Re z - alpha) |(z - B)^-1| over Re z > alpha                             (a)

bounds what comes before that mode: K <= sup_t exp(-alpha t) |exp(B t)| <= e n K, n the size of B
(their chapters 14 and 18). K is at least 1 (z far to the right) and at least the condition number
of a simple leading eigenvalue (z next to it).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
import scipy  # loads its parts when they are used
from jaxtyping import Complex, Float

from celltrain.parameters import CaseError
from celltrain.quantities import Quantity, Record
from celltrain.stability.coordinates import normed_block
from celltrain.stability.neutral import neutral_space
from celltrain.stability.norms import Norm, PaperNorm
from celltrain.stability.result import Stability
from celltrain.steady import Base

Matrix = Complex[np.ndarray, "size size"]

# Search for the supremum: distances from the abscissa relative to the size of the matrix, the
# closest far enough for the eigenvalue to be told from it, and rows for each.
CLOSEST = 1e-7
DISTANCES = 36
ROWS = 24
# Distance from the others, relative to the same size, at which an eigenvalue counts as simple.
APART = 1e-6


@dataclass(frozen=True)
class Window:
    """A rectangle of the complex plane, in U/r0."""

    left: float
    right: float
    bottom: float
    top: float

    def __post_init__(self) -> None:
        if not (self.left < self.right and self.bottom < self.top):
            raise CaseError(
                f"window = {self.left:g} to {self.right:g}, {self.bottom:g} to {self.top:g} is not"
                " allowed; allowed: left < right, bottom < top"
            )


@dataclass(frozen=True)
class Kreiss:
    """The Kreiss constant, Eq. (a) of the module, and the z at which it is found, in U/r0.

    If `point` is an eigenvalue or far away, the supremum is the limit there.
    """

    constant: Annotated[
        float,
        Quantity(
            "K",
            "1",
            "Kreiss constant",
            equation=r"K = \sup (\mathrm{Re} z - \alpha) |(z - B)^{-1}|",
            source="Trefethen & Embree (2005), chapter 14",
        ),
    ]
    point: Annotated[complex, Quantity("z", "U/r0", "where it is found")]


@dataclass(frozen=True, eq=False)
class Pseudospectrum(Record):
    """Pseudospectra of the block A_m(q), q = 2 pi j/N with j = `wave_number`, in U/r0.

    `smallest` is the smallest singular value of z - B at z = real + i imaginary.
    """

    kind: ClassVar[str] = "pseudospectrum"
    title: ClassVar[str] = "pseudospectra of a block of the linear dynamics"

    base: Base
    azimuthal_number: Annotated[int, Quantity("m", "1", "azimuthal number of the block")]
    wave_number: Annotated[int, Quantity("j", "1", "wave number of the block")]
    norm: Annotated[str, Quantity("", "1", "norm of disturbances")]
    real: Annotated[
        Float[np.ndarray, " column"],
        Quantity(r"\mathrm{Re} z", "U/r0", "real parts of the grid", bulky=True),
    ]
    imaginary: Annotated[
        Float[np.ndarray, " row"],
        Quantity(r"\mathrm{Im} z", "U/r0", "imaginary parts of the grid", bulky=True),
    ]
    smallest: Annotated[
        Float[np.ndarray, "row column"],
        Quantity(
            r"1/|(z - B)^{-1}|", "U/r0", "smallest singular value of z - B on the grid", bulky=True
        ),
    ]
    eigenvalues: Annotated[
        Complex[np.ndarray, " eigenvalue"],
        Quantity(r"\lambda", "U/r0", "eigenvalues, neutral modes left out"),
    ]
    spectral_abscissa: Annotated[
        float, Quantity(r"\alpha", "U/r0", "largest growth rate of the block")
    ]
    numerical_abscissa: Annotated[
        float, Quantity(r"\eta", "U/r0", "largest initial growth rate of the block")
    ]
    kreiss: Kreiss


def smallest_singular_value(
    matrix: Matrix,
) -> Callable[[complex], float]:
    """The smallest singular value of z - B as a function of z; B is reduced to Schur form once."""
    triangular = scipy.linalg.schur(matrix, output="complex")[0]
    unit = np.eye(len(matrix))

    def smallest(z: complex) -> float:
        return float(np.linalg.svd(z * unit - triangular, compute_uv=False)[-1])

    return smallest


def kreiss_constant(matrix: Matrix) -> Kreiss:
    """The Kreiss constant of B - alpha, alpha the spectral abscissa of B.

        K = sup (Re z - alpha) |(z - B)^-1| over Re z > alpha,     Eq. (a) of the module.

    Searched on lines Re z - alpha in equal ratios, next to the imaginary parts of the eigenvalues
    and between them, then by the simplex method; a lower bound of the supremum in any case.
    """
    values, left, right = scipy.linalg.eig(matrix, left=True, right=True)
    abscissa, scale = float(values.real.max()), float(np.linalg.norm(matrix, 2))
    first = int(np.argmax(values.real))
    best, place = 1.0, complex(np.inf, 0.0)
    if np.sort(np.abs(values - values[first]))[1:].min(initial=np.inf) > APART * scale:
        # Next to a simple eigenvalue |(z - B)^-1| = |l| |r|/(|l^H r| |z - lambda|).
        best = 1.0 / float(abs(left[:, first].conj() @ right[:, first]))
        place = complex(values[first])
    smallest = smallest_singular_value(matrix)
    # The eigenvalues to the right matter close to the axis, all heights far from it.
    leading = values[np.argsort(-values.real)][:ROWS].imag

    def quotient(distance: float, height: float) -> float:
        return distance / smallest(complex(abscissa + distance, height))

    start, start_value = place, 0.0
    for distance in scale * np.geomspace(CLOSEST, 10.0, DISTANCES):
        between = np.linspace(leading.min() - distance, leading.max() + distance, ROWS)
        for height in np.concatenate([leading, between]):
            value = quotient(distance, height)
            if value > start_value:
                start_value, start = value, complex(abscissa + distance, height)
    distance = start.real - abscissa
    lowest = min(float(np.log(CLOSEST * scale / distance)), 0.0)

    def near(u: Float[np.ndarray, "2"]) -> complex:
        away = distance * float(np.exp(max(u[0], lowest)))
        return complex(abscissa + away, start.imag + distance * float(u[1]))

    def lowered(u: Float[np.ndarray, "2"], /, *_: object) -> float:
        return -quotient(near(u).real - abscissa, near(u).imag)

    found = scipy.optimize.minimize(lowered, np.zeros(2), method="Nelder-Mead", tol=1e-10)
    for point, value in ((start, start_value), (near(found.x), float(-found.fun))):
        if value > best:
            best, place = value, point
    return Kreiss(best, place)


def pseudospectrum(
    result: Stability,
    azimuthal_number: int,
    wave_number: int,
    *,
    norm: Norm | None = None,
    window: Window | None = None,
    points: int = 101,
) -> Pseudospectrum:
    """Pseudospectra of one block, 1/|(z - B)^-1| on a grid of z, and its Kreiss constant.

    **Arguments:**

    - `result`: the linear dynamics.
    - `azimuthal_number`, `wave_number`: m and j of the block.
    - `norm`: of disturbances; that of the paper, Eq. (8), if not given.
    - `window`: the part of the plane; if not given, about the axis and the abscissas.
    - `points`: of the grid, each way.

    **Raises:** `CaseError` for a block that is not there, or fewer than two points.
    """
    if azimuthal_number not in result.azimuthal_numbers:
        allowed = ", ".join(str(m) for m in result.azimuthal_numbers)
        raise CaseError(f"azimuthal_number = {azimuthal_number} is not allowed; allowed: {allowed}")
    if not 0 <= wave_number < len(result.wave_numbers):
        last = len(result.wave_numbers) - 1
        raise CaseError(f"wave_number = {wave_number} is not allowed; allowed: 0 to {last}")
    if points < 2:
        raise CaseError(f"points = {points} is not allowed; allowed: whole numbers >= 2")
    norm = PaperNorm() if norm is None else norm
    gram = norm.grams(result.base.coefficients, [azimuthal_number])[azimuthal_number]
    neutral = neutral_space(result.base, azimuthal_number, wave_number)
    block = normed_block(result.blocks[azimuthal_number][wave_number], gram, neutral)
    values = scipy.linalg.eigvals(block.matrix)
    abscissa, eta = block.spectral_abscissa, block.numerical_abscissa
    if window is None:
        size = max(eta, 4.0 * abs(abscissa))
        window = Window(-3.0 * size, 1.5 * size, -2.0 * size, 2.0 * size)
    real = np.linspace(window.left, window.right, points)
    imaginary = np.linspace(window.bottom, window.top, points)
    smallest = smallest_singular_value(block.matrix)
    return Pseudospectrum(
        base=result.base,
        azimuthal_number=azimuthal_number,
        wave_number=wave_number,
        norm=norm.name,
        real=real,
        imaginary=imaginary,
        smallest=np.array([[smallest(complex(x, y)) for x in real] for y in imaginary]),
        eigenvalues=values.astype(complex),
        spectral_abscissa=abscissa,
        numerical_abscissa=eta,
        kreiss=kreiss_constant(block.matrix),
    )
