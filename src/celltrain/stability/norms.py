"""Norms of a shape disturbance, on which the numerical abscissa depends.

A norm is a Gram matrix on the disturbances of each azimuthal number, |d|^2 = d^H G d. A choice is
an object, so a new norm is one small class.
"""

import abc
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from celltrain.harmonics import (
    Shape,
    azimuthal_weight,
    degree_of,
    degrees_and_orders,
    member_count,
    profile_of,
)
from celltrain.meridian.grids import meridian_grid

Grams = dict[int, Float[np.ndarray, "size size"]]


class Norm(abc.ABC):
    """A norm of disturbances."""

    name: str

    @abc.abstractmethod
    def grams(self, shape: Shape, azimuthal_numbers: Sequence[int]) -> Grams:
        """Gram matrix in `azimuthal_basis(degree, m)` for each m.

        `shape` is one cell of the steady train.
        """


@dataclass(frozen=True)
class OrthonormalNorm(Norm):
    """Sum of squares of the coefficients of orthonormal harmonics: the mean over solid angle."""

    name: str = "orthonormal"

    def grams(self, shape: Shape, azimuthal_numbers: Sequence[int]) -> Grams:
        """Unit matrices."""
        degree = degree_of(shape)
        return {m: np.eye(member_count(degree, m)) for m in azimuthal_numbers}


def paper_weights(degree: int) -> Float[np.ndarray, " coefficient"]:
    """Square of the paper's coefficient over that of the orthonormal one, by coefficient.

    The paper's Legendre functions have int P^2 sin(theta) dtheta = 1 and its cosines and sines are
    bare, so its coefficients are s/sqrt(2 pi) for order 0 and s/sqrt(pi) otherwise.
    """
    _, order = degrees_and_orders(degree)
    return np.where(order == 0, 0.5, 1.0) / np.pi


@dataclass(frozen=True)
class PaperNorm(Norm):
    """Eq. (8) of Bryngelson & Freund (2018): sum of squares of the paper's coefficients.

    It counts a disturbance of order 0 half (see `paper_weights`).
    """

    name: str = "paper"

    def grams(self, shape: Shape, azimuthal_numbers: Sequence[int]) -> Grams:
        """Diagonal matrices."""
        degree = degree_of(shape)
        grams = {}
        for m in azimuthal_numbers:
            weights = np.full(member_count(degree, m), 1.0 / np.pi)
            # Of order 0 are z for m = 0, and what turns as exp(i (m - 1) phi) for m = 1.
            if m == 0:
                weights[:degree] *= 0.5
            if m == 1:
                weights[len(weights) - degree :] *= 0.5
            grams[m] = np.diag(weights)
        return grams


@dataclass(frozen=True)
class SurfaceNorm(Norm):
    """Mean square displacement over the area of the steady membrane."""

    name: str = "surface"

    def grams(self, shape: Shape, azimuthal_numbers: Sequence[int]) -> Grams:
        """Dense matrices."""
        profile = profile_of(shape)
        # The area is no polynomial; its square is one of degree 4 M.
        grid = meridian_grid(profile.shape[1], 2 * profile.shape[1])
        area = np.hypot(*grid.area_vectors(profile)) * grid.weights
        mean = area / (2.0 * np.pi * area.sum())
        grams = {}
        for m in azimuthal_numbers:
            members = grid.members(m)
            weighted = members * (azimuthal_weight(m) * mean)
            grams[m] = np.einsum("cup,cvp->uv", weighted, members)
        return grams


NORMS: tuple[Norm, ...] = (PaperNorm(), OrthonormalNorm(), SurfaceNorm())
