"""Error bars of eigenvalues: from four degrees more, and from finer grids.

An eigenvalue lambda of the discrete dynamics differs from that of the train by what the degree of
the shapes leaves out and by what grids, rules and tolerances at that degree do:

    bar = |lambda(M) - lambda(M + 4)| + |lambda - lambda(finer rules)|,

both with a steady train of their own (finer rules: see `refined`). An eigenvalue is recognised
in the other computation, within its own m and q, by its vector: r, padded with zeros to the other
degree, has the amplitude |l_k^H r| in the other's mode k (adjoint l_k, see `adjoint`), and modes
are paired so that these are largest. A pair with an amplitude below 1/2 is none: its bar is not a
number.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Complex, Float
from scipy.optimize import linear_sum_assignment

from celltrain.harmonics import azimuthal_basis
from celltrain.parameters import CaseError, Train
from celltrain.stability.linearise import linear_blocks
from celltrain.stability.neutral import neutral_space
from celltrain.stability.result import ErrorBar, Mode, Stability
from celltrain.stability.spectrum import BlockSpectrum, block_spectrum
from celltrain.steady import Base, NotConverged, change_degree, steady
from celltrain.train.accuracy import refined

#: How many degrees more the first part takes.
MORE_DEGREES = 4
#: Modes that get a bar unless told otherwise.
COUNT = 6
LEAST_OVERLAP = 0.5

Places = dict[tuple[int, int], list[Mode]]
Found = dict[Mode, tuple[complex, float]]


def with_error_bars(
    result: Stability, *, count: int = COUNT, progress: Callable[[int, int], None] | None = None
) -> Stability:
    """The same result with error bars of its leading modes that are not neutral.

        bar = |lambda(M) - lambda(M + 4)| + |lambda - lambda(finer rules)|     (see the module).

    It takes a steady train and blocks at four degrees more, about five times what those of the
    result took, and others with finer rules, about twice.

    **Arguments:** `count`: how many modes; `progress`: called with (computations done, all).

    **Raises:** `CaseError` for a count that is not allowed. A computation that is not possible
    (sizes of grids chosen by hand, no convergence) leaves bars that are not numbers.
    """
    check_count(count)
    begin = time.perf_counter()
    modes = [mode for mode in result.modes if not mode.neutral][:count]
    places: Places = {}
    for mode in modes:
        places.setdefault((mode.azimuthal_number, mode.wave_number), []).append(mode)
    found: list[Found] = []
    for number, change in enumerate((_more_degrees, refined)):
        found.append(_found(result, places, change))
        if progress is not None:
            progress(number + 1, 2)
    bars = (_bar(mode, *(each.get(mode, (np.nan, 0.0)) for each in found)) for mode in modes)
    spent = time.perf_counter() - begin
    seconds = {**result.seconds, "error_bars": spent, "total": result.seconds["total"] + spent}
    return replace(result, error_bars=tuple(bars), seconds=seconds)


def check_count(count: int) -> None:
    """See to it that there is a mode to get a bar.

    **Raises:** `CaseError` if not.
    """
    if count < 1:
        raise CaseError(f"error_bars = {count} is not allowed; allowed: whole numbers >= 1")


def _bar(mode: Mode, finer: tuple[complex, float], ruled: tuple[complex, float]) -> ErrorBar:
    value = complex(mode.growth_rate, mode.frequency)
    return ErrorBar(
        mode=mode,
        by_degree=float(abs(finer[0] - value)),
        by_rules=float(abs(ruled[0] - value)),
        overlap=min(finer[1], ruled[1]),
    )


def _more_degrees(train: Train) -> Train:
    return train.changed(degree=train.degree + MORE_DEGREES)


def _found(result: Stability, places: Places, change: Callable[[Train], Train]) -> Found:
    """The eigenvalues of modes, and their overlaps, for a train that is computed otherwise."""
    try:
        train = change(result.base.train)
        base = steady(train, start=result.base, estimate_error=False)
    except (CaseError, NotConverged):
        return {}
    numbers = sorted({m for m, _ in places})
    waves = sorted({wave for _, wave in places})
    q = 2.0 * np.pi * np.array(waves) / train.cells
    blocks = linear_blocks(train, base.coefficients, q, numbers)
    found: Found = {}
    for (m, wave), modes in places.items():
        block = blocks[m][waves.index(wave)]
        spectrum = block_spectrum(block, neutral_space(base, m, wave))
        vectors = [result.right_vectors[m][wave, :, mode.index] for mode in modes]
        found |= _paired(modes, [_padded(each, m, result.base, base) for each in vectors], spectrum)
    return found


def _padded(
    vector: Complex[np.ndarray, " size"], m: int, before: Base, after: Base
) -> Complex[np.ndarray, " other"]:
    """A vector in the basis of another degree."""
    old, new = (azimuthal_basis(each.train.degree, m) for each in (before, after))
    field = np.einsum("u,uik->ik", vector, old)
    degree = after.train.degree
    wider = change_degree(field.real, degree) + 1j * change_degree(field.imag, degree)
    return np.einsum("uik,ik->u", new, wider)


def _paired(
    modes: Sequence[Mode],
    vectors: Sequence[Complex[np.ndarray, " size"]],
    spectrum: BlockSpectrum,
) -> Found:
    """Each mode's eigenvalue in another spectrum, and its overlap there."""
    free = np.array([kind == "" for kind in spectrum.kinds])
    overlaps: Float[np.ndarray, "mode eigenvalue"] = np.abs(
        np.stack(vectors) @ spectrum.left[:, free].conj()
    )
    rows, columns = linear_sum_assignment(-overlaps)
    values = spectrum.eigenvalues[free]
    return {
        modes[int(row)]: (complex(values[column]), float(overlaps[row, column]))
        for row, column in zip(rows, columns, strict=True)
        if overlaps[row, column] >= LEAST_OVERLAP
    }
