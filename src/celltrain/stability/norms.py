"""Norms of a shape disturbance, on which the numerical abscissa depends.

A norm is a Gram matrix on the disturbances of one azimuthal number, |d|^2 = d^H G d. A choice is an
object, so a new norm is one small class.
"""

import abc
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from celltrain.harmonics import degrees_and_orders, harmonic_tables, sphere_grid
from celltrain.train import azimuthal_basis

Shape = Float[np.ndarray, "3 coefficient"]


class Norm(abc.ABC):
    """A norm of disturbances."""

    name: str

    @abc.abstractmethod
    def gram(self, shape: Shape, m: int) -> Float[np.ndarray, "size size"]:
        """Gram matrix in `azimuthal_basis(degree, m)`; `shape` is one cell of the steady train."""


@dataclass(frozen=True)
class OrthonormalNorm(Norm):
    """Sum of squares of the coefficients of orthonormal harmonics: the mean over solid angle."""

    name: str = "orthonormal"

    def gram(self, shape: Shape, m: int) -> Float[np.ndarray, "size size"]:
        """Gram matrix of this norm."""
        degree = int(np.sqrt(shape.shape[-1]))
        return np.eye(len(azimuthal_basis(degree, m)))


@dataclass(frozen=True)
class PaperNorm(Norm):
    """Eq. (8) of Bryngelson & Freund (2018): sum of squares of the paper's coefficients.

    Its Legendre functions have int P^2 sin(theta) dtheta = 1 and its cosines and sines are bare, so
    its coefficients are s/sqrt(2 pi) for order 0 and s/sqrt(pi) otherwise. The norm thus counts a
    disturbance of order 0 half.
    """

    name: str = "paper"

    def gram(self, shape: Shape, m: int) -> Float[np.ndarray, "size size"]:
        """Gram matrix of this norm."""
        degree = int(np.sqrt(shape.shape[-1]))
        _, order = degrees_and_orders(degree)
        weight = np.where(order == 0, 0.5, 1.0) / np.pi
        basis = azimuthal_basis(degree, m)
        return np.einsum("uik,k,vik->uv", basis, weight, basis)


@dataclass(frozen=True)
class SurfaceNorm(Norm):
    """Mean square displacement over the area of the steady membrane."""

    name: str = "surface"

    def gram(self, shape: Shape, m: int) -> Float[np.ndarray, "size size"]:
        """Gram matrix of this norm."""
        degree = int(np.sqrt(shape.shape[-1]))
        grid = sphere_grid(degree, 2 * degree)
        theta, phi = grid.points()
        tables = harmonic_tables(degree, theta, phi)
        cross = np.cross(np.asarray(tables.d_theta) @ shape.T, np.asarray(tables.d_phi) @ shape.T)
        area = np.linalg.norm(cross, axis=-1) / np.sin(theta) * np.asarray(grid.weights)
        displaced = np.einsum("uik,pk->upi", azimuthal_basis(degree, m), np.asarray(grid.values))
        return np.einsum("upi,p,vpi->uv", displaced, area / area.sum(), displaced)


NORMS: tuple[Norm, ...] = (PaperNorm(), OrthonormalNorm(), SurfaceNorm())
