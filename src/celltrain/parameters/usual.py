"""Cases that are allowed, but unlike any red blood cell in a capillary: values misread, mostly.

A profile in micrometres, a radius of 2.8 where 2.8e-6 is meant, a velocity in mm/s: what is
computed of them is right, and means nothing. Who means it says so, by `unusual = true`.
"""

import warnings
from collections.abc import Mapping

import numpy as np

from celltrain.parameters.errors import CaseError
from celltrain.parameters.fields import described
from celltrain.parameters.profile import enclosed
from celltrain.parameters.scales import REFERENCE, Scales
from celltrain.parameters.sections import Cell

#: Largest factor between a profile's volume and a healthy cell's, either way.
VOLUME_FACTOR = 3.0
#: Largest factor between scales and those of a red blood cell in a capillary, either way.
SCALE_FACTOR = 10.0

_HOW = "for others, unusual = true at the top of the case file, or --unusual"


class UnusualCase(UserWarning):
    """A train made in Python that is unlike any red blood cell in a capillary."""


def is_meant(given: dict[str, object]) -> bool:
    """Whether a case says that it is unusual, taken from what is given.

    Raises:
        CaseError: if it says neither true nor false.
    """
    unusual = given.pop("unusual", False)
    if not isinstance(unusual, bool):
        raise CaseError(f"unusual = {unusual!r} is not allowed; allowed: true or false")
    return unusual


def relative_volume(cell: Cell) -> float | None:
    """Volume of the profile's cell over a healthy one's, 4 pi/3 r0^3; None without a profile."""
    points = cell.profile
    return None if points is None else abs(enclosed(np.array(points))) / (4.0 * np.pi / 3.0)


def check_volume(cell: Cell) -> None:
    """Refuse a profile whose cell has not about a red blood cell's volume.

    Raises:
        CaseError: with its volume and its largest radius, as read.
    """
    found = _volume(cell)
    if found is not None:
        volume, usual = found
        raise CaseError(f"this profile is not allowed: {volume}; allowed: {usual}; {_HOW}")


def check_scales(given: Mapping[str, object]) -> None:
    """Refuse scales that are no red blood cell's in a capillary.

    Raises:
        CaseError: for what is no scale at all, and with each value in the unit in which it is read.
    """
    lines = [
        f"{value} is not allowed; allowed: {usual}; {_HOW}"
        for value, usual in _scales(Scales.of(given))
    ]
    if lines:
        raise CaseError("\n".join(lines))


def warn_of_unusual(cell: Cell, scales: Scales) -> None:
    """Warn who called the caller of this of what is no red blood cell's in a capillary."""
    found = _scales(scales)
    if (volume := _volume(cell)) is not None:
        found.append((f"this profile: {volume[0]}", volume[1]))
    for value, usual in found:
        words = f"{value}; usual: {usual}; if it is meant, say unusual=True"
        warnings.warn(words, UnusualCase, stacklevel=3)


def _volume(cell: Cell) -> tuple[str, str] | None:
    """The volume of a profile's cell in words, and what is usual; None if it is."""
    volume = relative_volume(cell)
    if volume is None or 1.0 / VOLUME_FACTOR <= volume <= VOLUME_FACTOR:
        return None
    widest = max(rho for rho, _ in cell.profile or ())
    return (
        f"read in r0, its largest radius is {widest:.4g} r0 and its volume {volume:.4g} times a"
        " healthy cell's",
        f"a volume of 1/{VOLUME_FACTOR:g} to {VOLUME_FACTOR:g} times (a healthy cell's largest"
        " radius is 1.39 r0)",
    )


def _scales(scales: Scales) -> list[tuple[str, str]]:
    """Each scale that is unusual in words, and what is usual."""
    found = []
    for name, field in Scales.model_fields.items():
        value, usual = getattr(scales, name), getattr(REFERENCE, name)
        if not usual / SCALE_FACTOR <= value <= usual * SCALE_FACTOR:
            meaning, unit = described(field).rsplit(", ", 1)
            found.append(
                (
                    f"{name} = {value:g} {unit} ({meaning})",
                    f"{usual / SCALE_FACTOR:g} to {usual * SCALE_FACTOR:g} {unit}",
                )
            )
    return found
