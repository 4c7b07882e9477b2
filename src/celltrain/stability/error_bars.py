"""Error bars of eigenvalues: from higher degrees, and from finer rules.

An eigenvalue lambda of the discrete dynamics differs from that of the train by what the degree of
the shapes leaves out and by what the rules at that degree do:

    bar = |lambda(M) - lambda(M'')| + |lambda(M') - lambda(M'')| + |lambda - lambda(finer rules)|,

M' and M'' the next two degrees of the ladder (the last two below, where there is none above), and
all with a steady train of their own. An eigenvalue is recognised in another computation, within its
own m and q, by its vector: r, padded with zeros to the other degree, has the amplitude |l_k^H r| in
the other's mode k (adjoint l_k, see `adjoint`), and modes are paired so that these are largest. A
pair with an amplitude below 1/2 is none: its bar is NaN.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import scipy  # loads its parts when they are used
from jaxtyping import Complex, Float

from celltrain.harmonics import azimuthal_families
from celltrain.parameters import CaseError
from celltrain.stability.linearise import linear_blocks
from celltrain.stability.neutral import neutral_space
from celltrain.stability.result import ErrorBar, Mode, Stability
from celltrain.stability.spectrum import BlockSpectrum, block_spectrum
from celltrain.steady import Base, NotConverged
from celltrain.steady.degree import higher
from celltrain.steady.problem import SteadyProblem
from celltrain.steady.solve import at_degree, with_finer_rules

#: Modes that get a bar unless told otherwise.
COUNT = 6
LEAST_OVERLAP = 0.5
# Degrees below that stand in where there are not two above.
LOWER = (4, 8)

Places = dict[tuple[int, int], list[Mode]]
Found = dict[Mode, tuple[complex, float]]


def with_error_bars(
    result: Stability, *, count: int = COUNT, progress: Callable[[int, int], None] | None = None
) -> Stability:
    """The same result with error bars of its leading modes that are not neutral.

        bar = |lambda(M) - lambda(M'')| + |lambda(M') - lambda(M'')| + |change by finer rules|

    (see the module).

    **Arguments:** `count`: how many modes; `progress`: called with (computations done, all).

    **Raises:** `CaseError` for a count that is not allowed. A computation that is not possible
    leaves bars of NaN.
    """
    check_count(count)
    begin = time.perf_counter()
    base = result.base
    modes = [mode for mode in result.modes if not mode.neutral][:count]
    places: Places = {}
    for mode in modes:
        places.setdefault((mode.azimuthal_number, mode.wave_number), []).append(mode)
    degree = base.train.degree
    above = higher(degree)[:2]
    if len(above) < 2:
        above = tuple(degree - each for each in LOWER)
    computations: list[Callable[[], Base]] = [
        lambda: at_degree(base, above[0]),
        lambda: at_degree(base, above[1]),
        lambda: with_finer_rules(base),
    ]
    found: list[Found] = []
    for number, compute in enumerate(computations, 1):
        found.append(_found(result, places, compute, finer=number == 3))
        if progress is not None:
            progress(number, len(computations))
    bars = (_bar(mode, *(each.get(mode, (np.nan, 0.0)) for each in found)) for mode in modes)
    spent = time.perf_counter() - begin
    seconds = {**result.seconds, "error_bars": spent, "total": result.seconds["total"] + spent}
    return replace(result, error_bars=tuple(bars), seconds=seconds)


def check_count(count: int) -> None:
    """Check that there is a mode to get a bar.

    **Raises:** `CaseError` if not.
    """
    if count < 1:
        raise CaseError(f"error_bars = {count} is not allowed; allowed: whole numbers >= 1")


def _bar(
    mode: Mode,
    near: tuple[complex, float],
    far: tuple[complex, float],
    ruled: tuple[complex, float],
) -> ErrorBar:
    value = complex(mode.growth_rate, mode.frequency)
    return ErrorBar(
        mode=mode,
        by_degree=float(abs(far[0] - value) + abs(far[0] - near[0])),
        by_rules=float(abs(ruled[0] - value)),
        overlap=min(near[1], far[1], ruled[1]),
    )


def _found(result: Stability, places: Places, compute: Callable[[], Base], *, finer: bool) -> Found:
    """The eigenvalues of modes, and their overlaps, for a train that is computed otherwise."""
    try:
        base = compute()
    except (CaseError, NotConverged):
        return {}
    numbers = sorted({m for m, _ in places if m <= base.train.degree})
    waves = sorted({wave for _, wave in places})
    phases = 2.0 * np.pi * np.array(waves) / base.train.cells
    rules = SteadyProblem(base.train, finer=True).rules(base.profile) if finer else None
    blocks = linear_blocks(base, phases, numbers, rules=rules)
    found: Found = {}
    for (m, wave), modes in places.items():
        if m not in blocks:
            continue
        spectrum = block_spectrum(blocks[m][waves.index(wave)], neutral_space(base, m, wave))
        vectors = [result.right_vectors[m][wave, :, mode.index] for mode in modes]
        degrees = result.base.train.degree, base.train.degree
        found |= _paired(modes, [_padded(each, m, *degrees) for each in vectors], spectrum)
    return found


def _padded(
    vector: Complex[np.ndarray, " size"], m: int, before: int, after: int
) -> Complex[np.ndarray, " other"]:
    """A vector in the basis of another degree: each family cut, or padded with zeros."""
    old, new = (
        [len(family) for family in azimuthal_families(degree, m)] for degree in (before, after)
    )
    padded, start = [], 0
    for size, wanted in zip(old, new, strict=True):
        family = np.zeros(wanted, dtype=complex)
        count = min(size, wanted)
        family[:count] = vector[start : start + count]
        padded.append(family)
        start += size
    return np.concatenate(padded)


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
    rows, columns = scipy.optimize.linear_sum_assignment(-overlaps)
    values = spectrum.eigenvalues[free]
    return {
        modes[int(row)]: (complex(values[column]), float(overlaps[row, column]))
        for row, column in zip(rows, columns, strict=True)
        if overlaps[row, column] >= LEAST_OVERLAP
    }
