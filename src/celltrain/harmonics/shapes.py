"""What the coefficients of shapes say by themselves: degree, mean points, displacements.

A shape is x_i(theta, phi) = sum_c s_ic Y_c(theta, phi), i = x, y, z, with the harmonics of degree n
below M, so with M^2 columns. Since Y_00 = 1/sqrt(4 pi), a displacement by d adds sqrt(4 pi) d to
the first column, and the root of the sum of the squares of all coefficients is sqrt(4 pi) times a
root-mean-square length.

All functions take arrays of NumPy and of JAX, and give back what they took.
"""

import math
from typing import Any, Protocol, TypeVar, runtime_checkable

import numpy as np
from jaxtyping import Float

#: One shape, and those of several cells, in r0; of JAX: `jax_shapes`.
Shape = Float[np.ndarray, "3 coefficient"]
Shapes = Float[np.ndarray, "cell 3 coefficient"]

#: The first coefficient of a displacement by one unit of length.
UNIT_DISPLACEMENT = math.sqrt(4.0 * math.pi)


@runtime_checkable
class Numbers(Protocol):
    """What arrays of NumPy and of JAX have in common, as far as it is needed here."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Sizes of the axes."""
        ...

    def __getitem__(self, key: Any) -> Any:
        """Elements."""
        ...

    def __add__(self, other: Any) -> Any:
        """Sum."""
        ...

    def __matmul__(self, other: Any) -> Any:
        """Product of matrices."""
        ...

    def swapaxes(self, first: int, second: int, /) -> "Numbers":
        """The array with two axes exchanged."""
        ...


Kind = TypeVar("Kind", bound=Numbers)


def degree_of(coefficients: Numbers) -> int:
    """The degree M of coefficients [..., M^2]: the harmonics are those with n < M.

    **Raises:** `ValueError` if their number is not a square.
    """
    count = coefficients.shape[-1]
    degree = math.isqrt(count)
    if degree**2 != count:
        raise ValueError(f"{count} coefficients are not those of all harmonics below a degree")
    return degree


def mean_points(shapes: Float[Kind, "*cell 3 coefficient"]) -> Float[Kind, "*cell 3"]:
    """Mean of the points of each shape over solid angle, in r0: Y_00 times the first column.

    Of rates of change it is the mean velocity. It is the centroid of symmetric shapes only.
    """
    return shapes[..., 0] / UNIT_DISPLACEMENT


def displaced(
    shapes: Float[Kind, "*cell 3 coefficient"], by: Float[Numbers, "*#cell 3"]
) -> Float[Kind, "*cell 3 coefficient"]:
    """The shapes, each moved by a vector (r0) of its own or all by one."""
    first = np.zeros(shapes.shape[-1])
    first[0] = UNIT_DISPLACEMENT
    return shapes + by[..., None] * first


def displaced_along(
    shapes: Float[Kind, "*cell 3 coefficient"], distance: float | Float[Numbers, "*#cell"]
) -> Float[Kind, "*cell 3 coefficient"]:
    """The shapes moved by distances (r0) along the tube, +z."""
    if not isinstance(distance, float | int):
        distance = distance[..., None]
    return displaced(shapes, distance * np.array([0.0, 0.0, 1.0]))


def surface_points(
    shapes: Float[Kind, "*cell 3 coefficient"], harmonics: Float[Kind, "point coefficient"]
) -> Float[Kind, "*cell point 3"]:
    """Points of the surfaces where the harmonics have the given values, in r0.

    With rates of change in place of shapes, the velocities there; with derivatives of the harmonics
    in place of their values, tangents.
    """
    return harmonics @ shapes.swapaxes(-2, -1)
