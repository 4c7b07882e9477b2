"""The numbers of each case of a study: what they are, and how they come from its stability."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

from celltrain.contract import OfStability, analysis_named, commands
from celltrain.diagnostics import mode_motion
from celltrain.diagnostics.mechanisms import ModeTurning
from celltrain.parameters import CaseError
from celltrain.quantities import Quantity, Record, numbers, quantities
from celltrain.stability import Mode, Stability, TransientMode
from celltrain.steady import Base


@dataclass(frozen=True)
class Column:
    """A number of each case: what it is, and how it comes from a result."""

    meaning: Quantity
    of: Callable[[Any], float]


def _taken(kind: type, path: str, names: Iterable[str], prefix: str = "") -> dict[str, Column]:
    """Columns for quantities of a part of a stability."""
    known, dot = quantities(kind), "." if path else ""
    return {prefix + name: Column(known[name], attrgetter(path + dot + name)) for name in names}


def _axisymmetric(result: Stability) -> float:
    # What a march of the axisymmetric train alone would reach has none that grow.
    return max(
        mode.growth_rate
        for mode in result.modes
        if mode.azimuthal_number == 0 and mode.wave_number == 0 and not mode.neutral
    )


_TURNING = quantities(ModeTurning)

#: Numbers of every case, by name.
COLUMNS: dict[str, Column] = {
    **_taken(Base, "base", numbers(Base)),
    **_taken(Stability, "", ("spectral_abscissa", "error_estimate")),
    "taken_degree": Column(
        Quantity("M", "1", "degree of the shapes, given or as the accuracy asks for"),
        lambda result: float(result.base.train.degree),
    ),
    **_taken(Mode, "leading", ("azimuthal_number", "wave_number", "frequency"), "leading_"),
    "tumbling": Column(
        _TURNING["tumbling"], lambda result: mode_motion(result, result.leading).tumbling
    ),
    "tank_treading": Column(
        _TURNING["tank_treading"], lambda result: mode_motion(result, result.leading).tank_treading
    ),
    "axisymmetric_growth_rate": Column(
        Quantity(
            r"\alpha_0(0)",
            "U/r0",
            "largest growth rate of what is axisymmetric and alike in all cells; where it is"
            " positive, a march from rest would not have ended in this steady train",
        ),
        _axisymmetric,
    ),
    **_taken(Stability, "", ("numerical_abscissa",)),
    **_taken(TransientMode, "transient", ("azimuthal_number", "wave_number"), "transient_"),
    "case_seconds": Column(
        Quantity("", "s", "wall time of a case"), lambda result: result.seconds["total"]
    ),
}
#: Words of every case.
WORDS = {
    "status": Quantity("", "1", "whether a case is finished, failed, or not computed yet"),
    "reason": Quantity("", "1", "why a case failed, empty if it did not"),
    "origin": Quantity("", "1", "how the steady train of a case was reached"),
}


def further(analyses: Iterable[str]) -> dict[str, Column]:
    """The columns of further analyses, `ANALYSIS_QUANTITY`: their results' single numbers.

    Raises:
        CaseError: for an analysis that there is not, or that needs settings, or does not go on
            from a case's stability.
    """
    found: dict[str, Column] = {}
    for name in analyses:
        analysis = further_analysis(name)
        for number, meaning in numbers(type(analysis).result).items():
            found[f"{name}_{number}"] = Column(meaning, attrgetter(number))
    return found


def further_analysis(name: str) -> OfStability[Record]:
    """An analysis of a case's stability, with its usual settings.

    Raises:
        CaseError: as `further`.
    """
    kind = analysis_named(name) if name in commands() else None
    if kind is None or not issubclass(kind, OfStability):
        allowed = [each for each in commands() if issubclass(analysis_named(each), OfStability)]
        raise CaseError(f"analyses = {name!r} is not allowed; allowed: {', '.join(allowed)}")
    return kind()
