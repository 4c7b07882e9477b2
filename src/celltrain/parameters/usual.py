"""Cases that are allowed, but unlike any red blood cell in a capillary: values misread, mostly.

A profile in micrometres, a radius of 2.8 where 2.8e-6 is meant, a velocity in mm/s: what is
computed of them is right, and means nothing. Who means it says so, by `unusual = true`.
"""

from collections.abc import Mapping

import numpy as np

from celltrain.parameters.errors import CaseError
from celltrain.parameters.fields import described
from celltrain.parameters.profile import enclosed
from celltrain.parameters.scales import REFERENCE, Scales
from celltrain.parameters.train import Train

#: Largest factor between a profile's volume and a healthy cell's, either way.
VOLUME_FACTOR = 3.0
#: Largest factor between scales and those of a red blood cell in a capillary, either way.
SCALE_FACTOR = 10.0

_HOW = "for others, unusual = true at the top of the case file, or --unusual"


def relative_volume(train: Train) -> float | None:
    """Volume of the profile's cell over a healthy one's, 4 pi/3 r0^3; None without a profile."""
    points = train.cell.profile
    return None if points is None else abs(enclosed(np.array(points))) / (4.0 * np.pi / 3.0)


def check_volume(train: Train) -> None:
    """Refuse a profile whose cell has not about a red blood cell's volume.

    Raises:
        CaseError: with its volume and its largest radius, as read.
    """
    volume = relative_volume(train)
    if volume is None or 1.0 / VOLUME_FACTOR <= volume <= VOLUME_FACTOR:
        return
    widest = max(rho for rho, _ in train.cell.profile or ())
    raise CaseError(
        f"this profile is not allowed: read in r0, its largest radius is {widest:.4g} r0 and its"
        f" volume {volume:.4g} times a healthy cell's; allowed: a volume of 1/{VOLUME_FACTOR:g} to"
        f" {VOLUME_FACTOR:g} times (a healthy cell's largest radius is 1.39 r0); {_HOW}"
    )


def check_scales(given: Mapping[str, object]) -> None:
    """Refuse scales that are no red blood cell's in a capillary.

    Raises:
        CaseError: for what is no scale at all, and with each value in the unit in which it is read.
    """
    scales, lines = Scales.of(given), []
    for name in given:
        value, usual = getattr(scales, name), getattr(REFERENCE, name)
        if not usual / SCALE_FACTOR <= value <= usual * SCALE_FACTOR:
            meaning, unit = described(Scales.model_fields[name]).rsplit(", ", 1)
            lines.append(
                f"{name} = {value:g} {unit} ({meaning}) is not allowed; allowed:"
                f" {usual / SCALE_FACTOR:g} to {usual * SCALE_FACTOR:g} {unit}; {_HOW}"
            )
    if lines:
        raise CaseError("\n".join(lines))
