"""A cell in free space seen from targets at a distance: its nearest periodic images.

The fields of `kernels` on a product grid of the source, moved along the tube by a multiple of the
period. The rule's error falls as exp(-2 n d/h), n points in theta, d the distance of the target and
h = |dx/dtheta| of the source there, for d well below h; `rules` chooses n. Prefactor 1/8 pi.
"""

from collections.abc import Callable

import numpy as np
from jaxtyping import Float

from celltrain.harmonics import Profile
from celltrain.meridian.grids import HalfCircle, MeridianGrid
from celltrain.meridian.kernels import (
    EVEN,
    ODD,
    STRESS_EVEN,
    STRESS_ODD,
    force_fields,
    stress_fields,
)
from celltrain.meridian.moments import Moments
from celltrain.meridian.own_surface import GROUP


class ImageMoments:
    """Moments of a kernel over one image of a cell; `integrals` are the sums of the even fields."""

    def __init__(
        self,
        sources: MeridianGrid,
        integrals: Float[np.ndarray, "even_field target"],
        even: Float[np.ndarray, "order even_field target theta"],
        odd: Float[np.ndarray, "order odd_field target theta"],
    ) -> None:
        self.integrals = integrals
        self._sources = sources
        self._fields = even, odd

    def at(self, order: int) -> tuple[Moments, Moments]:
        """Moments of the even and the odd fields for an order."""
        value = self._sources.tables(order).value[order].T
        even, odd = self._fields
        return even[order] @ value, odd[order] @ value


def force_image(
    sources: MeridianGrid,
    circle: HalfCircle,
    targets: tuple[np.ndarray, np.ndarray],
    profile: Profile,
    force: Profile,
    shift: float,
    orders: int,
) -> ImageMoments:
    """Moments of G and T for a cell moved by `shift` (r0) along the tube.

    **Arguments:** `targets`: axial position and distance from the axis; `orders`: for o < `orders`.
    """
    content = _around(circle, *sources.places(force))
    return _image(
        sources, circle, targets, profile, content, shift, orders, force_fields, (EVEN, ODD)
    )


def stress_image(
    sources: MeridianGrid,
    circle: HalfCircle,
    targets: tuple[np.ndarray, np.ndarray],
    profile: Profile,
    shift: float,
    orders: int,
) -> ImageMoments:
    """Moments of K for the shape of a cell moved by `shift` (r0) along the tube."""
    content = _around(circle, *sources.area_vectors(profile))
    names = (STRESS_EVEN, STRESS_ODD)
    return _image(sources, circle, targets, profile, content, shift, orders, stress_fields, names)


def _around(circle: HalfCircle, axial: np.ndarray, radial: np.ndarray) -> np.ndarray:
    """Cartesian components [3, source] of an axisymmetric field on the product grid."""
    return np.stack(
        [
            np.outer(radial, np.cos(circle.phi)).ravel(),
            np.outer(radial, np.sin(circle.phi)).ravel(),
            np.repeat(axial, circle.count),
        ]
    )


def _image(
    sources: MeridianGrid,
    circle: HalfCircle,
    targets: tuple[np.ndarray, np.ndarray],
    profile: Profile,
    content: np.ndarray,
    shift: float,
    orders: int,
    kernel: Callable[..., None],
    names: tuple[tuple[str, ...], tuple[str, ...]],
) -> ImageMoments:
    z, rho = targets
    axial, radial = sources.places(profile)
    points = _around(circle, axial + shift, radial)
    weights = np.repeat(sources.weights * circle.weight / (8.0 * np.pi), circle.count)
    turns = circle.cosines(orders), circle.sines(orders)
    step = max(1, GROUP // (8 * weights.size * (len(names[0]) + len(names[1]))))
    parts = []
    for first in range(0, len(z), step):
        group = slice(first, first + step)
        shape = (3, len(z[group]), weights.size)
        here, there = (np.broadcast_to(each[:, None], shape) for each in (points, content))
        even, odd = (np.empty((len(each), *shape[1:])) for each in names)
        kernel(rho[group], z[group], here, there, weights, even, odd)
        reduced = [
            np.moveaxis(each.reshape(*each.shape[:2], sources.size, -1) @ turn, 3, 0)
            for each, turn in zip((even, odd), turns, strict=True)
        ]
        parts.append((even.sum(2), *reduced))
    integrals, of_even, of_odd = zip(*parts, strict=True)
    return ImageMoments(
        sources,
        np.concatenate(integrals, axis=1),
        np.ascontiguousarray(np.concatenate(of_even, axis=2)),
        np.ascontiguousarray(np.concatenate(of_odd, axis=2)),
    )
