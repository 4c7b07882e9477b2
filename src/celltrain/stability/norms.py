"""Norms of a shape disturbance, on which the numerical abscissa depends.

A norm is a Gram matrix on the disturbances of each azimuthal number, |d|^2 = d^H G d. A choice is
an object, so a new norm is one small class.
"""

import abc
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from celltrain.harmonics import azimuthal_basis, degrees_and_orders
from celltrain.train import area_vectors

Shape = Float[np.ndarray, "3 coefficient"]
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
        degree = int(np.sqrt(shape.shape[-1]))
        return {m: np.eye(len(azimuthal_basis(degree, m))) for m in azimuthal_numbers}


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
        degree = int(np.sqrt(shape.shape[-1]))
        weight = paper_weights(degree)
        grams = {}
        for m in azimuthal_numbers:
            basis = azimuthal_basis(degree, m)
            grams[m] = np.tensordot(basis * weight, basis, axes=((1, 2), (1, 2)))
        return grams


@dataclass(frozen=True)
class SurfaceNorm(Norm):
    """Mean square displacement over the area of the steady membrane."""

    name: str = "surface"

    def grams(self, shape: Shape, azimuthal_numbers: Sequence[int]) -> Grams:
        """Dense matrices."""
        degree = int(np.sqrt(shape.shape[-1]))
        vectors, weights, values = area_vectors(shape)
        area = np.linalg.norm(vectors, axis=-1) * weights
        metric = (values * (area / area.sum())[:, None]).T @ values
        grams = {}
        for m in azimuthal_numbers:
            basis = azimuthal_basis(degree, m)
            grams[m] = np.tensordot(basis @ metric, basis, axes=((1, 2), (1, 2)))
        return grams


NORMS: tuple[Norm, ...] = (PaperNorm(), OrthonormalNorm(), SurfaceNorm())
