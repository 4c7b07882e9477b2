"""The meridian of a cell's resting shape, given point by point, as from a file."""

import warnings
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from jaxtyping import Float
from pydantic import BeforeValidator

from celltrain.parameters.errors import CaseError

#: Fewest and most points of a meridian.
LEAST_POINTS, MOST_POINTS = 8, 2000
#: How close to the axis, in r0, a meridian's ends are.
ON_AXIS = 1e-6


def _meridian(given: Any) -> Any:
    """The points of a meridian, from a file's name or from pairs; None stays what it is.

    Raises:
        CaseError: if the file cannot be read, or the points are no meridian of a closed surface
            that does not cross itself.
    """
    if given is None:
        return None
    points = _read(Path(given)) if isinstance(given, str | Path) else _pairs(given)
    _check(points)
    if enclosed(points) < 0.0:
        points = points[::-1]
    return tuple((float(rho), float(z)) for rho, z in points)


#: Points (distance from the axis, height) in r0 from the upper pole to the lower one; a file's name
#: is read at once, so that a case holds the points themselves.
Profile = Annotated[tuple[tuple[float, float], ...], BeforeValidator(_meridian)]


def enclosed(points: Float[np.ndarray, "point 2"]) -> float:
    """Volume inside the surface of revolution, r0^3; negative from the lower pole to the upper."""
    (rho, z), (rho_next, z_next) = points[:-1].T, points[1:].T
    cones = (rho**2 + rho * rho_next + rho_next**2) / 3.0
    return float(np.pi * np.sum(cones * (z - z_next)))


def _read(path: Path) -> np.ndarray:
    try:
        # Some editors begin a file with a byte-order mark; an empty one is refused by its size.
        with open(path, encoding="utf-8-sig") as file, warnings.catch_warnings(action="ignore"):
            return np.loadtxt(file, delimiter=",", ndmin=2)
    except OSError as error:
        raise CaseError(f"profile {str(path)!r} cannot be read: {error.strerror}") from None
    except ValueError as error:
        raise CaseError(
            f"profile {str(path)!r} is not allowed: {error}; allowed: lines of two numbers,"
            " distance from the axis and height in r0, with a comma between them, and comments"
            " after #"
        ) from None


def _pairs(given: Any) -> np.ndarray:
    try:
        return np.array([[float(each) for each in pair] for pair in given]).reshape(-1, 2)
    except (TypeError, ValueError):
        raise CaseError(
            f"profile = {str(given)[:60]} is not allowed; allowed: the name of a file, or pairs"
            " of numbers"
        ) from None


def _check(points: np.ndarray) -> None:
    if points.shape[1] != 2 or not LEAST_POINTS <= len(points) <= MOST_POINTS:
        raise CaseError(
            f"a profile of {len(points)} points with {points.shape[1]} numbers is not allowed;"
            f" allowed: {LEAST_POINTS} to {MOST_POINTS} points with 2 numbers"
        )
    if not np.isfinite(points).all():
        number = int(np.argmin(np.isfinite(points).all(axis=1)))
        raise CaseError(
            f"point {number + 1} of the profile, {points[number, 0]:g} and {points[number, 1]:g},"
            " is not allowed; allowed: finite numbers"
        )
    rho = points[:, 0]
    if np.abs(rho[[0, -1]]).max() > ON_AXIS or rho[1:-1].min() <= ON_AXIS:
        raise CaseError(
            "this profile is not allowed: its first and last point are on the axis (distance 0),"
            " all others off it (distance > 0)"
        )
    if (np.linalg.norm(np.diff(points, axis=0), axis=1) == 0.0).any():
        raise CaseError("this profile is not allowed: it has a point twice in a row")
    if _crosses(points):
        raise CaseError("this profile is not allowed: it crosses itself")


def _crosses(points: np.ndarray) -> bool:
    """Whether pieces of the meridian that do not follow each other have a point in common."""
    start, step = points[:-1], np.diff(points, axis=0)

    def cross(one: np.ndarray, other: np.ndarray) -> np.ndarray:
        return one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]

    apart = start[None] - start[:, None]
    scale = cross(step[:, None], step[None])
    with np.errstate(divide="ignore", invalid="ignore"):
        along, across = (cross(apart, each) / scale for each in (step[None], step[:, None]))
    meet = (along >= 0) & (along <= 1) & (across >= 0) & (across <= 1)
    return bool(np.triu(meet, 2).any())
