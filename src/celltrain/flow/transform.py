"""Fourier transforms between points in the tube and the wave vectors of the far kernel.

    analyse:     f^(k) = sum_s f_s exp(-i k . y_s)
    synthesise:  u(x)  = sum_k u^(k) exp(i k . x)

(see `nonuniform`), where modes of negative kz are left out.
"""

import math

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from celltrain.flow.ewald import EwaldSplit
from celltrain.flow.nonuniform import (
    Angles,
    Modes,
    modes_to_points,
    numbers_of_modes,
    points_to_modes,
)
from celltrain.runtime import constant

Points = Float[Array, "point 3"]


class Transform(eqx.Module):
    """Transform between points and the modes of one box, for real fields.

    `box` is its size in r0 along x, y and z, `largest` the largest wave numbers there, in waves for
    each box.
    """

    largest: tuple[int, int, int] = eqx.field(static=True)
    tolerance: float = eqx.field(static=True)
    box: Float[Array, "3"]

    def wave_vectors(self) -> tuple[Array, Array, Array]:
        """Components kx, ky, kz, broadcastable to the shape of the modes, in 1/r0."""
        x, y, z = (
            (2.0 * math.pi / self.box[i]) * each
            for i, each in enumerate(numbers_of_modes(self.largest))
        )
        return x, y, z

    def analyse(self, points: Points, strengths: Float[Array, "point field"]) -> Modes:
        """Modes of strengths at the points, with forward derivatives in both."""
        return points_to_modes(self.largest, strengths, self._angles(points), self.tolerance)

    def synthesise(self, points: Points, modes: Modes) -> Float[Array, "point field"]:
        """Fields at the points, with forward derivatives in both."""
        return modes_to_points(modes, self._angles(points), self.tolerance)

    def _angles(self, points: Points) -> Angles:
        return points * (2.0 * math.pi / self.box)


def transform(split: EwaldSplit, width: float, period: float, tolerance: float) -> Transform:
    """Transform for points in a box (sizes in r0)."""
    across, along = (
        math.ceil(split.largest_wave_number * length / (2.0 * math.pi))
        for length in (width, period)
    )
    box = constant(np.array([width, width, period], dtype=float))
    return Transform((across, across, along), tolerance, box)
