"""Whether there can be a train: whether the cell passes the tube, and cells fit in a row.

A membrane keeps its area nearly, and its volume exactly. Of all shapes of area A and volume V the
cylinder with two half spheres passes the narrowest tube (Canham & Burton 1968), whose radius r is
the smallest root of

    A r/2 - (2/3) pi r^3 = V,    r = 2 s sin(arcsin(3 V/(4 pi s^3))/3),

s = sqrt(A/(4 pi)) the radius of the sphere of that area.

Cells of a period L that do not overlap have L at most of any line along the tube, so V <= L S with
S the area of the cell's shadow along the tube. That is within the tube, and a closed surface has at
least twice the area of its shadow:

    packing = 1/L <= min(pi R^2, A/2)/V.
"""

import math

from celltrain.membrane import meridian_membrane
from celltrain.parameters import CaseError, Train


def least_diameter(area: float, volume: float) -> float:
    """Diameter of the narrowest tube that a cell of this area and volume passes, in r0."""
    sphere = math.sqrt(area / (4.0 * math.pi))
    reduced_volume = volume / (4.0 / 3.0 * math.pi * sphere**3)
    # A sphere has no area to spare: two roots meet there, up to rounding.
    if reduced_volume >= 1.0 - 1e-12:
        return 2.0 * sphere
    return 4.0 * sphere * math.sin(math.asin(reduced_volume) / 3.0)


def check_room(train: Train) -> None:
    """Check that the cells can pass the tube, and that it has room for them.

    **Raises:** `CaseError` if not, with the least diameter or the largest packing.
    """
    membrane = meridian_membrane(train)
    area, volume = (each(membrane.rest_profile) for each in (membrane.area, membrane.volume))
    least = least_diameter(area, volume)
    if train.tube.diameter <= least:
        raise CaseError(
            f"diameter = {train.tube.diameter:g} is not allowed: a cell of area {area:.3f} r0^2 and"
            f" volume {volume:.3f} r0^3 passes no tube as narrow; allowed: > {least:.4f}"
        )
    section = math.pi * train.radius**2
    most = min(section, 0.5 * area) / volume
    if train.packing >= most:
        why = (
            "the cells would fill more than the tube"
            if section <= 0.5 * area
            else f"cells of area {area:.3f} r0^2 and volume {volume:.3f} r0^3 would overlap"
        )
        raise CaseError(
            f"packing = {train.packing:g} is not allowed: {why}; allowed: > 0 and < {most:.4f}"
        )
