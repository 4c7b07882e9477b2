"""A result as plain numbers and lists, for programs."""

import math
from typing import Any

from celltrain.results.version import version
from celltrain.stability import (
    ErrorBar,
    Mode,
    NeutralDefect,
    Stability,
    leading_condition,
    neutral_defects,
)
from celltrain.steady import Base

#: How many of the leading modes a summary lists.
LEADING_MODES = 24


def summary(result: Base | Stability) -> dict[str, Any]:
    """What matters of a result as an object that JSON can hold, in r0, U and mu.

    Always there: `version`, `case` (in the sections of a case file), `cell_velocity`, `gap`,
    `largest_radius`, `effective_viscosity`, `residual`, `truncation_error`,
    `velocity_error`, `origin`, `seconds`. Of a :class:`Stability` also `spectral_abscissa`,
    `numerical_abscissa`, `numerical_abscissas`, `error_estimate` with the `degree` and the
    `convergence` that tell it, the `condition_number` of the leading eigenvalue, `leading_modes`,
    sorted by growth rate, `neutral_defects` (what the dynamics makes of neutral modes before
    deflation), and if they were asked for `error_bars` and with them `growth_sign` (1, -1, or 0
    where the bars do not tell). Numbers that are not finite become None.
    """
    base = result.base if isinstance(result, Stability) else result
    content: dict[str, Any] = {
        "version": version(),
        "case": {**base.train.sections(), "scales": base.train.scales.model_dump()},
        "cell_velocity": base.cell_velocity,
        "gap": base.gap,
        "largest_radius": base.largest_radius,
        "effective_viscosity": base.effective_viscosity,
        "residual": base.residual,
        "truncation_error": base.truncation_error,
        "velocity_error": base.velocity_error,
        "origin": base.origin,
    }
    if isinstance(result, Stability):
        content |= {
            "spectral_abscissa": result.spectral_abscissa,
            "numerical_abscissa": result.numerical_abscissa,
            "numerical_abscissas": result.numerical_abscissas,
            "error_estimate": result.error_estimate,
            "degree": result.base.train.degree,
            "convergence": {
                "degrees": list(result.convergence.degrees),
                "spectral_abscissas": list(result.convergence.values),
            },
            "condition_number": leading_condition(result),
            "leading_modes": [_mode(mode) for mode in result.modes[:LEADING_MODES]],
            "neutral_defects": [_defect(defect) for defect in neutral_defects(result)],
            "error_bars": [_bar(bar) for bar in result.error_bars],
            "growth_sign": result.growth_sign,
        }
    plain: dict[str, Any] = _plain({**content, "seconds": result.seconds})
    return plain


def _mode(mode: Mode) -> dict[str, Any]:
    return {
        "growth_rate": mode.growth_rate,
        "frequency": mode.frequency,
        "azimuthal_number": mode.azimuthal_number,
        "wave_number": mode.wave_number,
        "neutral": mode.neutral,
        "neutral_kind": mode.neutral_kind,
        "multiplicity": mode.multiplicity,
    }


def _defect(defect: NeutralDefect) -> dict[str, Any]:
    return {
        "kind": defect.kind,
        "wave_number": defect.wave_number,
        "growth_rate": defect.raw.real,
        "frequency": defect.raw.imag,
        "residual": defect.residual,
    }


def _bar(bar: ErrorBar) -> dict[str, Any]:
    return {
        **_mode(bar.mode),
        "error": bar.total,
        "by_degree": bar.by_degree,
        "by_rules": bar.by_rules,
        "overlap": bar.overlap,
    }


def _plain(value: Any) -> Any:
    """The same without NumPy's types, and with None for what JSON has no number for."""
    if isinstance(value, dict):
        return {str(name): _plain(entry) for name, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    if hasattr(value, "item"):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
