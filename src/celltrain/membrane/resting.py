"""The shape at rest that a cell's parameters describe."""

import numpy as np
import scipy  # loads its parts when they are used
from jaxtyping import Float

from celltrain.harmonics import (
    Shape,
    coefficients_of,
    legendre_functions,
    profile_of,
    project_meridian,
)
from celltrain.harmonics.grading import regraded
from celltrain.membrane.equilibrium import relaxed_shape
from celltrain.membrane.reference import reference_coefficients
from celltrain.parameters import CaseError, Cell
from celltrain.parameters.reference_shape import spheroid_axes

#: Largest distance, in r0, of a profile's points from the shape that a degree makes of them.
LARGEST_MISFIT = 0.02


def resting_shape(cell: Cell, degree: int, grading: float = 0.0) -> Shape:
    """Coefficients, below `degree`, of a cell at rest, its axis the tube's.

    **Arguments:** `grading` of the meridian (see `harmonics.grading`).

    **Raises:** `CaseError` for a profile that the degree cannot follow, or if no shape of the
    cell's reduced volume was found.
    """
    shape = _usual_shape(cell, degree)
    if grading == 0.0:
        return shape
    return coefficients_of(regraded(profile_of(shape), 0.0, grading))


def _usual_shape(cell: Cell, degree: int) -> Shape:
    """The same without grading."""
    if cell.reduced_volume is not None:
        return relaxed_shape(degree, cell.reduced_volume)
    if cell.profile is not None:
        return profile_shape(np.array(cell.profile), degree)
    if cell.aspect_ratio is not None:
        radius, height = spheroid_axes(cell.aspect_ratio)
        return np.array([[radius], [radius], [height]]) * reference_coefficients(degree, "sphere")
    return reference_coefficients(degree, cell.reference)


def profile_shape(points: Float[np.ndarray, "point 2"], degree: int) -> Shape:
    """Coefficients of the surface with a meridian through points, its mean height at 0.

    A cubic spline in the chord length; theta is its arc length, scaled. Then the projection on the
    harmonics.

    **Raises:** `CaseError` if a point is farther from the surface than `LARGEST_MISFIT`.
    """
    chord = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    # Mirror images of the first and the last piece make the poles smooth.
    mirrored = np.concatenate([[-chord[1]], chord, [2.0 * chord[-1] - chord[-2]]])
    ends = np.concatenate([points[1:2] * [-1.0, 1.0], points, points[-2:-1] * [-1.0, 1.0]])
    spline = scipy.interpolate.CubicSpline
    distance, height = (spline(mirrored, ends[:, i]) for i in (0, 1))
    fine = np.linspace(0.0, chord[-1], 20 * len(points) + 1)
    speed = np.hypot(distance(fine, 1), height(fine, 1))
    middles = 0.5 * (speed[1:] + speed[:-1]) * np.diff(fine)
    arc = np.concatenate([[0.0], np.cumsum(middles)])
    place = spline(np.pi * arc / arc[-1], fine)

    def meridian(theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return distance(place(theta)), height(place(theta))

    profile = project_meridian(degree, meridian, max(64, 3 * degree))
    legendre = legendre_functions(degree, 1, np.pi * np.interp(chord, fine, arc) / arc[-1])
    found = np.stack([profile[1] @ legendre[1], profile[0] @ legendre[0]], axis=1)
    misfit = float(np.linalg.norm(found - points, axis=1).max())
    if misfit > LARGEST_MISFIT:
        raise CaseError(
            f"degree = {degree} is not allowed with this profile: its shape is {misfit:.3f} r0 away"
            f" from a point, allowed: {LARGEST_MISFIT:g} r0; take a higher degree"
        )
    profile[0, 0] = 0.0
    return coefficients_of(profile)
