"""The numbers that a slider of the explorer moves: ranges, and the units that people read.

A control stands for a leaf of a case, and changes it as the command line's option does: a capillary
number changes all moduli, a mean velocity in SI leaves their SI values. A slider's place goes from
0 to 1 over its range, which is a choice of what is shown; fields take whatever a case allows.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from celltrain.parameters import CaseError, Train, merge_case
from celltrain.parameters.dimension import BENDING_MODULUS, LENGTH, SURFACE_MODULUS, Dimension
from celltrain.parameters.fields import allowed_values, plain_type
from celltrain.parameters.routing import DIMENSIONS, KEPT, TAKEN
from celltrain.parameters.scales import REFERENCE, Scales
from celltrain.parameters.strength import MODULI
from celltrain.parameters.train import Units

#: The reduced volume of a cell whose case gives none: the healthy one's.
HEALTHY = 0.6444
#: How SI values are read: the unit's name, and its value in SI.
READ_IN: dict[Dimension, tuple[str, float]] = {
    LENGTH: ("µm", 1e-6),
    SURFACE_MODULUS: ("µN/m", 1e-6),
    BENDING_MODULUS: ("10⁻¹⁹ N m", 1e-19),
}
_VELOCITY = ("mm/s", 1e-3)
_SIGNS = {"mu": "µ", "r0^2": "r₀²", "r0": "r₀"}


@dataclass(frozen=True)
class Control:
    """A slider with its field; `least` and `most` are in r0, U and mu at the reference scales."""

    name: str
    label: str
    least: float
    most: float
    logarithmic: bool = False
    digits: int = 3

    def shown_as(self, units: Units) -> "Control":
        """The control in its place: in SI the mean velocity for the capillary number."""
        return VELOCITY if units == "SI" and self.name == "capillary_number" else self

    def unit(self, units: Units) -> tuple[str, float]:
        """The unit's name and its value, in that of the case in these units."""
        if self.name == "mean_velocity":
            return _VELOCITY
        dimension = DIMENSIONS[self.name]
        if units == "SI":
            return READ_IN.get(dimension, ("", 1.0))
        words = dimension.unit if dimension.unit != "1" else ""
        for plain, sign in _SIGNS.items():
            words = words.replace(plain, sign)
        return words, 1.0

    def value(self, train: Train, units: Units) -> float:
        """The value in a case, in the unit that is shown."""
        if self.name == "mean_velocity":
            return train.scales.mean_velocity / self.unit(units)[1]
        known = train.leaf(self.name)
        value = float(known) if isinstance(known, int | float) else HEALTHY
        dimension = DIMENSIONS[self.name]
        scale = train.scales.unit(dimension) if units == "SI" else 1.0
        return value * scale / self.unit(units)[1]

    def place(self, value: float, units: Units) -> float:
        """Where a shown value stands on the slider, 0 to 1."""
        low, high = self.range(units)
        if self.logarithmic:
            if value <= 0.0:
                return 0.0
            low, high, value = math.log(low), math.log(high), math.log(value)
        return min(max((value - low) / (high - low), 0.0), 1.0)

    def at(self, place: float, units: Units) -> float:
        """The shown value at a place of the slider, in a few digits as one would type it."""
        low, high = self.range(units)
        ratio = (high / low) ** place
        value = low * ratio if self.logarithmic else low + (high - low) * place
        return float(f"{value:.{self.digits}g}")

    def range(self, units: Units) -> tuple[float, float]:
        """The shown values at the slider's ends."""
        scale = 1.0
        if units == "SI" and self.name != "mean_velocity":
            scale = REFERENCE.unit(DIMENSIONS[self.name]) / self.unit(units)[1]
        return self.least * scale, self.most * scale


def _words(name: str) -> str:
    return name.replace("_", " ").capitalize()


#: A modulus may be moved to this many times the usual one, and to that part of it.
SPAN = 20.0
VELOCITY = Control("mean_velocity", "Mean velocity", 0.1, 50.0, logarithmic=True)
#: What may be moved, in the order in which it is shown; the number of cells is apart.
CONTROLS = (
    Control("diameter", "Tube diameter", 2.6, 12.0),
    Control("packing", "Packing", 0.05, 0.9),
    Control("capillary_number", "Capillary number", 0.03, 15.0, logarithmic=True),
    Control("viscosity_ratio", "Viscosity ratio", 0.2, 20.0, logarithmic=True),
    *(
        Control(name, _words(name), usual / SPAN, usual * SPAN, logarithmic=True)
        for name in MODULI
        if (usual := KEPT[name].default) > 0.0
    ),
    Control("reduced_volume", "Reduced volume", 0.5, 1.0),
)
#: Most cells of the slider.
MOST_CELLS = 24


def controls(units: Units) -> tuple[Control, ...]:
    """The controls in these units."""
    return tuple(each.shown_as(units) for each in CONTROLS)


def parsed(name: str, text: str) -> int | float | str:
    """The value of a leaf that somebody wrote.

    Raises:
        CaseError: as for an option of the command line.
    """
    field = Scales.model_fields[name] if name in Scales.model_fields else TAKEN[name]
    kind = plain_type(field)
    try:
        return int(text) if kind is int else float(text) if kind is float else text
    except ValueError:
        raise CaseError(f"{name} = {text!r} is not allowed; {allowed_values(field)}") from None


def changed(train: Train, given: Mapping[str, object], units: Units) -> Train:
    """The case with leaves put over it, in r0, U and mu or in SI, as the command line does it.

    Only what is given changes, so that other values keep all their digits.

    Raises:
        CaseError: as when a train is made.
    """
    if units == "dimensionless":
        return train.changed(**given)
    # Says what is wrong in the words of a case in SI; what is unusual already may stay so.
    before = {**train.leaves("SI"), "units": "SI"}
    try:
        merge_case({}, before)
    except CaseError:
        before["unusual"] = True
    merge_case({}, {**before, **given})
    leaves = dict(given)
    scales = train.scales
    faster = leaves.pop("mean_velocity", None)
    if isinstance(faster, int | float):
        strength = train.cell.capillary_number * faster / scales.mean_velocity
        train = train.changed(capillary_number=strength)
        scales = Scales(**{**scales.model_dump(), "mean_velocity": faster})
    plain = {name: scales.dimensionless(DIMENSIONS[name], value) for name, value in leaves.items()}
    return train.changed(**plain, scales=scales)
