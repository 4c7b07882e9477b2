"""The numbers of a report with their errors, as rows of a table on a page."""

import math

from celltrain.analyses.base import FORMATS
from celltrain.explore.engine import Picture
from celltrain.explore.reading import Reading
from celltrain.parameters import Train
from celltrain.quantities.fields import quantity_of
from celltrain.stability import InfiniteTrain, Stability
from celltrain.stability.verdict import leading_error, verdict
from celltrain.steady import Base

#: A row: what it is, the value, its error (empty if there is none to tell), the unit.
Row = dict[str, str]
_LENGTHS = ("gap", "largest_radius")


def rows(result: Stability | InfiniteTrain | Base, reading: Reading) -> list[Row]:
    """What a report says of a result."""
    base = result if isinstance(result, Base) else result.base
    found = []
    if isinstance(result, Stability):
        found += _of_stability(result, reading)
    elif isinstance(result, InfiniteTrain):
        found += _of_waves(result, reading)
    return found + _of_base(base, reading)


def headline(result: Stability | InfiniteTrain | Base, reading: Reading) -> str:
    """A sentence on the result, as the report has it."""
    if isinstance(result, Stability):
        words = verdict(result)
        return words[0].upper() + words[1:].replace("r0", "r₀") + "."
    if isinstance(result, InfiniteTrain):
        best, (rate, unit) = result.most_unstable, reading.of("U/r0")
        length = f"{2.0 * math.pi / best.phase:.4g} cells a wave" if best.phase else "all alike"
        return (
            f"Most unstable wave: growth rate {best.growth_rate * rate:.4g} {unit},"
            f" m = {best.azimuthal_number}, q = {best.phase:.4g} ({length})."
        )
    return f"Steady train: the cells move at {result.cell_velocity:.4g} U."


def _of_stability(result: Stability, reading: Reading) -> list[Row]:
    rate, unit = reading.of("U/r0")
    mode = result.leading
    return [
        row("growth rate α", result.spectral_abscissa * rate, leading_error(result) * rate, unit),
        row("its frequency", mode.frequency * rate, math.nan, unit),
        row("initial growth rate η", result.numerical_abscissa * rate, math.nan, unit),
    ]


def _of_waves(result: InfiniteTrain, reading: Reading) -> list[Row]:
    rate, unit = reading.of("U/r0")
    best = result.most_unstable
    return [
        row("growth rate α", best.growth_rate * rate, result.error_estimate * rate, unit),
        row("its frequency", best.frequency * rate, math.nan, unit),
        row("its phase q", best.phase, math.nan, "rad"),
    ]


def _of_base(base: Base, reading: Reading) -> list[Row]:
    found = [{"name": "degree M", "value": str(base.train.degree), "error": "", "unit": ""}]
    if reading.si:
        capillary = f"{base.train.cell.capillary_number:.4g}"
        found.append({"name": "capillary number", "value": capillary, "error": "", "unit": ""})
    for name, form in FORMATS.items():
        known = quantity_of(Base, name)
        words = known.words.replace("cell velocity", "velocity of the cells")
        value = getattr(base, name)
        if isinstance(value, str):
            found.append({"name": words, "value": value, "error": "", "unit": ""})
            continue
        factor, unit = reading.of(known.meaning.unit)
        error = base.velocity_error * base.cell_velocity if name == "cell_velocity" else math.nan
        value *= factor
        if form.endswith("e"):
            found.append({"name": words, "value": f"{value:{form}}", "error": "", "unit": unit})
        else:
            found.append(row(words, value, error * factor, unit))
    return found


def row(name: str, value: float, error: float, unit: str) -> Row:
    """A number with as many digits as its error leaves, six if none is known."""
    known = math.isfinite(error) and error > 0.0
    if not math.isfinite(value):
        text = "not known"
    elif known and abs(value) > 0.0:
        digits = min(max(1 - math.floor(math.log10(error)), 0), 12)
        text = f"{value:.{digits}f}"
    else:
        text = f"{value:.6g}"
    return {"name": name, "value": text, "error": f"{error:.1g}" if known else "", "unit": unit}


def title(train: Train, reading: Reading, *, infinite: bool) -> str:
    """The case in a line."""
    length, unit = reading.of("r0")
    cells = "infinite train" if infinite else f"{train.cells} cells"
    return (
        f"D = {train.tube.diameter * length:.6g} {unit}, packing {train.packing:.6g}, {cells},"
        f" viscosity ratio {train.flow.viscosity_ratio:.4g}"
    )


def motion(base: Base) -> str:
    """What is seen of a steady train."""
    return f"The cells move at {base.cell_velocity:.4g} U, from left to right."


def report(picture: Picture, reading: Reading) -> dict[str, object]:
    """All words and numbers about a picture."""
    return {
        "title": title(picture.base.train, reading, infinite=picture.view.infinite),
        "headline": headline(picture.result, reading),
        "motion": motion(picture.base),
        "rows": rows(picture.result, reading),
        "converged": picture.converged,
        "degree": picture.base.train.degree,
        "given": picture.view.train.resolution.degree is not None,
    }
