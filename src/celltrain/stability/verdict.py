"""Whether a train is stable, in a sentence."""

import math

from celltrain.parameters.resolution import LARGEST_DEGREE
from celltrain.stability.infinite import InfiniteTrain
from celltrain.stability.result import Mode, Stability
from celltrain.steady import Base

#: A growth rate up to this (U/r0), or up to the resolution's own error, counts as none.
MARGINAL_GROWTH = 1e-4


def is_marginal(result: Stability) -> bool:
    """Whether no mode but the neutral ones grows faster than 1e-4 U/r0."""
    return result.spectral_abscissa <= MARGINAL_GROWTH


def leading_error(result: Stability) -> float:
    """The error of the leading growth rate: its bar if there is one, the estimate otherwise."""
    bars = {bar.mode: bar.total for bar in result.error_bars}
    return bars.get(result.leading, result.error_estimate)


def verdict(result: Stability) -> str:
    """Whether the train is stable, in a sentence; distances are those that the train travels."""
    mode, cells = result.leading, result.base.train.cells
    moved = f"cells in a wave of {cells / mode.wave_number:.3g}" if mode.wave_number else "the cell"
    if cells > 1 and mode.wave_number in (0, cells / 2):
        moved = wave_words(mode.wave_number, cells)
    motion = f"{_motion(mode.azimuthal_number, moved)}, {_wave_number(mode, cells)})"
    sign = _sign(result)
    return _sentence(result.base, result.spectral_abscissa, leading_error(result), motion, sign)


def infinite_verdict(result: InfiniteTrain) -> str:
    """Whether the infinite train is stable, in a sentence as that of `verdict`."""
    mode = result.most_unstable
    moved = (
        f"cells in a wave of {2.0 * math.pi / mode.phase:.3g}" if mode.phase else "all cells alike"
    )
    motion = f"{_motion(mode.azimuthal_number, moved)}, q = {mode.phase:.3g})"
    return _sentence(result.base, mode.growth_rate, result.error_estimate, motion)


def _sentence(base: Base, alpha: float, error: float, motion: str, sign: str = "") -> str:
    if alpha <= MARGINAL_GROWTH:
        known = "not estimated" if math.isnan(error) else f"{error:.1e} U/r0"
        return (
            f"marginally stable: nothing grows but the neutral modes (largest growth rate"
            f" {alpha:.1e} U/r0, the resolution's own error {known}){sign}"
        )
    if error >= alpha:
        return (
            f"not resolved: the largest growth rate {alpha:.1e} U/r0 is below its own error"
            f" {error:.1e} U/r0; {_remedy(base)}"
        )
    distance = base.cell_velocity / alpha
    return (
        f"unstable: the fastest disturbance grows e-fold over {distance:.3g} r0 of travel; it"
        f" {motion}"
    )


def wave_words(wave_number: int, cells: int) -> str:
    """The pattern of a wave along the train."""
    if wave_number == 0:
        return "all cells alike"
    if 2 * wave_number == cells:
        return "neighbours oppositely"
    return f"{cells / wave_number:.3g} cells a wave"


def _remedy(base: Base) -> str:
    if base.train.degree == LARGEST_DEGREE:
        return "no higher degree is offered"
    return "a higher degree, or none, so that it rises by itself, is needed"


def _sign(result: Stability) -> str:
    """What error bars say about the sign of a growth rate close to zero."""
    if result.growth_sign is None:
        return ""
    known = {1: "it is positive", -1: "it is negative", 0: "error bars leave its sign open"}
    return f"; {known[result.growth_sign]}"


def _motion(m: int, moved: str) -> str:
    """What a mode does to cells, told from its azimuthal number; a bracket is left open."""
    deeds = {0: "deforms {} axisymmetrically", 1: "tilts {}"}
    return f"{deeds.get(m, f'deforms {{}} {m}-fold around').format(moved)} (m = {m}"


def _wave_number(mode: Mode, cells: int) -> str:
    if mode.wave_number == 0:
        return "q = 0"
    if 2 * mode.wave_number == cells:
        return "q = pi"
    return f"q = 2 pi {mode.wave_number}/{cells}"
