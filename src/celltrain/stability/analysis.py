"""The stability of a steady train: all blocks, their spectra, and what stands out."""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from celltrain.clock import timed
from celltrain.parameters import Train
from celltrain.stability.convergence import (
    ACCURACY,
    NUMBERS,
    AbscissaLadder,
    Tell,
    check_linearisable,
)
from celltrain.stability.linearise import Blocks, Progress, linear_blocks
from celltrain.stability.neutral import neutral_space
from celltrain.stability.norms import NORMS
from celltrain.stability.result import Mode, Stability, TransientMode
from celltrain.stability.spectrum import BlockSpectrum, block_spectrum, numerical_abscissa
from celltrain.steady import Base
from celltrain.steady.base import IterationProgress
from celltrain.steady.solve import with_velocity_error


def stability(
    case: Train | Base,
    *,
    start: Base | None = None,
    accuracy: float = ACCURACY,
    azimuthal_numbers: Sequence[int] | None = None,
    estimate_error: bool = True,
    progress: Progress | None = None,
    iteration: IterationProgress | None = None,
    tell: Tell | None = None,
) -> Stability:
    """The linear dynamics of a train of N cells about its steady state.

    d' = A d falls apart into blocks A_m(q), q = 2 pi j/N (see `linear_blocks`), A v = lambda v:

        alpha = max Re lambda (Eq. 14, neutral modes set aside),
        eta = max d^H (G A + A^H G) d/(2 d^H G d) (Eq. 15, G the matrix of a norm).

    **Arguments:**

    - `case`: a case, or a steady train of it. The degree of a case that has none rises (12, 16, 20,
      24, 32, ... 64; from a higher one on in narrow tubes) until alpha is known to the accuracy;
      otherwise it is what it is.
    - `start`: a steady train of another case to go on from.
    - `accuracy`: of alpha, relative; where that is less, 1e-4 U/r0 are enough.
    - `azimuthal_numbers`: those to compute, 0 to M; all if not given.
    - `estimate_error`: of a given degree, by the abscissas at higher ones.
    - `progress`: called with (azimuthal numbers done, all); `iteration` with every iteration of the
      steady train; `tell` with what is being done.

    **Returns:** a `Stability`; its `error_estimate` is what the measured changes with the degree
    leave.

    **Raises:** `CaseError` for what is not allowed, `NotConverged` if there is no steady train.
    """
    begin = time.perf_counter()
    train = case.train if isinstance(case, Base) else case
    check_linearisable(train, azimuthal_numbers)
    asked = NUMBERS if azimuthal_numbers is None else azimuthal_numbers
    ladder = AbscissaLadder(case, [m for m in asked if m in NUMBERS] or asked, start=start)
    timings: dict[str, float] = {}
    while True:
        with timed(timings, "degree"):
            convergence = ladder.resolved(
                accuracy, estimate_error=estimate_error, iteration=iteration, tell=tell
            )
            base = ladder.base(convergence.degree)
        known = ladder.blocks(base.train.degree)
        spectra = _spectra(base, azimuthal_numbers, known, timings, progress)
        leading = next(mode for mode in spectra.modes if not mode.neutral)
        if leading.azimuthal_number in ladder.numbers:
            break
        # A mode that was not looked at leads: the degree has to follow it, too.
        ladder.look_at(leading.azimuthal_number)
    if math.isnan(base.velocity_error):
        base = with_velocity_error(base)
    with timed(timings, "spectrum"):
        abscissas, transient = _transient(base, spectra.blocks)
    timings |= {name: base.seconds.get(name, 0.0) for name in ("base", "velocity_error")}
    timings["total"] = time.perf_counter() - begin
    each = spectra.by_number
    return Stability(
        base=base,
        azimuthal_numbers=tuple(each),
        wave_numbers=np.arange(base.train.cells // 2 + 1),
        blocks=spectra.blocks,
        eigenvalues={m: np.stack([s.eigenvalues for s in found]) for m, found in each.items()},
        right_vectors={m: np.stack([s.right for s in found]) for m, found in each.items()},
        left_vectors={m: np.stack([s.left for s in found]) for m, found in each.items()},
        modes=spectra.modes,
        spectral_abscissa=leading.growth_rate,
        numerical_abscissa=abscissas["paper"],
        numerical_abscissas=abscissas,
        error_estimate=convergence.error,
        convergence=convergence,
        transient=transient,
        seconds=timings,
    )


@dataclass(frozen=True)
class _Spectra:
    """Blocks and spectra of a train by azimuthal number, and all modes in order."""

    blocks: Blocks
    by_number: dict[int, list[BlockSpectrum]]
    modes: tuple[Mode, ...]


def _spectra(
    base: Base,
    azimuthal_numbers: Sequence[int] | None,
    known: Blocks,
    timings: dict[str, float],
    progress: Progress | None,
) -> _Spectra:
    degree, cells = base.train.degree, base.train.cells
    numbers = tuple(range(degree + 1) if azimuthal_numbers is None else azimuthal_numbers)
    check_linearisable(base.train, numbers)
    waves = range(cells // 2 + 1)
    with timed(timings, "linearise"):
        phases = [2.0 * np.pi * j / cells for j in waves]
        missing = [m for m in numbers if m not in known]
        made = linear_blocks(base, phases, missing, progress=progress) if missing else {}
        blocks = {m: known[m] if m in known else made[m] for m in numbers}
    with timed(timings, "spectrum"):
        spectra = {
            m: [block_spectrum(blocks[m][j], neutral_space(base, m, j)) for j in waves]
            for m in numbers
        }
    return _Spectra(blocks, spectra, _sorted_modes(spectra, cells))


def _sorted_modes(spectra: dict[int, list[BlockSpectrum]], cells: int) -> tuple[Mode, ...]:
    modes = []
    for m, each in spectra.items():
        for wave, spectrum in enumerate(each):
            conjugate = 1 if wave == 0 or 2 * wave == cells else 2
            multiplicity = conjugate * (1 if m == 0 else 2)
            for index, (value, kind) in enumerate(
                zip(spectrum.eigenvalues, spectrum.kinds, strict=True)
            ):
                modes.append(
                    Mode(
                        growth_rate=float(value.real),
                        frequency=float(value.imag),
                        azimuthal_number=m,
                        wave_number=wave,
                        neutral=bool(kind),
                        multiplicity=multiplicity,
                        index=index,
                        neutral_kind=kind,
                    )
                )
    return tuple(sorted(modes, key=lambda mode: -mode.growth_rate))


def _transient(base: Base, blocks: Blocks) -> tuple[dict[str, float], TransientMode]:
    """Numerical abscissa in every norm, and the optimal disturbance in the paper's norm."""
    abscissas: dict[str, float] = {}
    optimal: TransientMode | None = None
    for norm in NORMS:
        best: TransientMode | None = None
        for m, gram in norm.grams(base.coefficients, tuple(blocks)).items():
            for wave, block in enumerate(blocks[m]):
                rate, vector = numerical_abscissa(block, gram)
                if best is None or rate > best.growth_rate:
                    best = TransientMode(rate, m, wave, vector)
        assert best is not None
        abscissas[norm.name] = best.growth_rate
        if norm.name == "paper":
            optimal = best
    assert optimal is not None
    return abscissas, optimal
