"""The stability of a steady train: all blocks, their spectra, and what stands out."""

import time
from collections.abc import Sequence

import numpy as np

from celltrain.clock import timed
from celltrain.parameters import CaseError, Train
from celltrain.parameters.resolution import LARGEST_DEGREE
from celltrain.programs import forget_many_programs
from celltrain.stability.linearise import Blocks, Progress, linear_blocks
from celltrain.stability.neutral import neutral_space
from celltrain.stability.norms import NORMS
from celltrain.stability.result import Mode, Stability, TransientMode
from celltrain.stability.spectrum import BlockSpectrum, block_spectrum, numerical_abscissa
from celltrain.steady import Base, NotConverged, steady

# How many degrees more the estimate of the resolution's error takes.
MORE_DEGREES = 2


def check_linearisable(train: Train, azimuthal_numbers: Sequence[int] | None) -> None:
    """See to it that the linear dynamics of a train can be had, before anything is computed.

    A train that has no degree yet may get any, so its azimuthal numbers are held to the largest.

    **Raises:** `CaseError` for an azimuthal number out of range.
    """
    if azimuthal_numbers is None:
        return
    degree = train.resolution.degree
    most = LARGEST_DEGREE if degree is None else degree
    wrong = [m for m in azimuthal_numbers if not isinstance(m, int) or not 0 <= m <= most]
    if wrong or not azimuthal_numbers:
        given = ", ".join(str(m) for m in wrong) or "none"
        raise CaseError(
            f"azimuthal_numbers = {given} is not allowed; allowed: whole numbers from 0 to the"
            f" degree, {'at most ' if degree is None else ''}{most}"
        )


def stability(
    base: Base,
    *,
    azimuthal_numbers: Sequence[int] | None = None,
    estimate_error: bool = True,
    progress: Progress | None = None,
) -> Stability:
    """The linear dynamics of a train of N cells about its steady state.

    d' = A d falls apart into blocks A_m(q), q = 2 pi j/N (see `linear_blocks`), A v = lambda v:

        alpha = max Re lambda (Eq. 14, neutral modes set aside),
        eta = max d^H (G A + A^H G) d/(2 d^H G d) (Eq. 15, G the matrix of a norm).

    **Arguments:**

    - `base`: from `steady`; it must be converged.
    - `azimuthal_numbers`: those to compute, 0 to M; all if not given. Few cost as much as all, up
      to the eigenvalues.
    - `estimate_error`: repeat the leading eigenvalue with two degrees more.
    - `progress`: called with (wave numbers done, all).

    **Returns:** a `Stability`.

    **Raises:** `CaseError` for an azimuthal number out of range.
    """
    forget_many_programs()
    begin = time.perf_counter()
    train = base.train
    degree, cells = train.degree, train.cells
    check_linearisable(train, azimuthal_numbers)
    numbers = tuple(range(degree + 1) if azimuthal_numbers is None else azimuthal_numbers)
    waves = np.arange(cells // 2 + 1)
    timings = dict(base.seconds)
    blocks = linear_blocks(
        train,
        base.coefficients,
        2.0 * np.pi * waves / cells,
        numbers,
        progress=progress,
        seconds=timings,
    )

    with timed(timings, "spectrum"):
        spectra = {
            m: [block_spectrum(blocks[m][j], neutral_space(base, m, int(j))) for j in waves]
            for m in numbers
        }
        modes = _sorted_modes(spectra, cells)
        leading = next(mode for mode in modes if not mode.neutral)
        abscissas, transient = _transient(base, blocks)
    error = float("nan")
    if estimate_error:
        with timed(timings, "error_estimate"):
            error = _resolution_error(base, leading)
    timings["total"] = time.perf_counter() - begin + sum(base.seconds.values())
    return Stability(
        base=base,
        azimuthal_numbers=numbers,
        wave_numbers=waves,
        blocks=blocks,
        eigenvalues={m: np.stack([s.eigenvalues for s in each]) for m, each in spectra.items()},
        right_vectors={m: np.stack([s.right for s in each]) for m, each in spectra.items()},
        left_vectors={m: np.stack([s.left for s in each]) for m, each in spectra.items()},
        modes=modes,
        spectral_abscissa=leading.growth_rate,
        numerical_abscissa=abscissas["paper"],
        numerical_abscissas=abscissas,
        error_estimate=error,
        transient=transient,
        seconds=timings,
    )


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
        candidates = []
        for m, gram in norm.grams(base.coefficients, tuple(blocks)).items():
            for wave, block in enumerate(blocks[m]):
                rate, vector = numerical_abscissa(block, gram)
                candidates.append(TransientMode(rate, m, wave, vector))
        best = max(candidates, key=lambda each: each.growth_rate)
        abscissas[norm.name] = best.growth_rate
        if norm.name == "paper":
            optimal = best
    assert optimal is not None
    return abscissas, optimal


def _resolution_error(base: Base, leading: Mode) -> float:
    """Change of the largest growth rate of the leading m and q by two more degrees.

    Not a number if the finer train cannot be had.
    """
    train = base.train
    try:
        # Grids chosen by hand may be too coarse for a higher degree.
        finer = train.changed(degree=train.degree + MORE_DEGREES)
        nearby = steady(finer, start=base, estimate_error=False)
    except (CaseError, NotConverged):
        return float("nan")
    m, wave = leading.azimuthal_number, leading.wave_number
    q = np.array([2.0 * np.pi * wave / train.cells])
    block = linear_blocks(finer, nearby.coefficients, q, [m])[m][0]
    spectrum = block_spectrum(block, neutral_space(nearby, m, wave))
    rates = [
        value.real
        for value, kind in zip(spectrum.eigenvalues, spectrum.kinds, strict=True)
        if not kind
    ]
    return abs(leading.growth_rate - max(rates))
