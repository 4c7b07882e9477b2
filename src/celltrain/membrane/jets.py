"""Second-order jets: numbers that carry their first and second derivatives along.

A jet is a function of k variables at each of some points, known to second order about the
variables' values there. Arithmetic follows the rules of differentiation,

    (f g)' = f g' + g f',   (f g)'' = f g'' + g f'' + f' g'^T + g' f'^T,
    (f^n)' = n f^(n-1) f',  (f^n)'' = n f^(n-1) f'' + n (n - 1) f^(n-2) f' f'^T,

so that a formula of arithmetic, evaluated on jets, yields its exact derivatives.
"""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from jaxtyping import Float

Constant: TypeAlias = int | float | Float[np.ndarray, ""] | Float[np.ndarray, " point"]


@dataclass(frozen=True)
class Jet:
    """Value, gradient and Hessian by point. Constants are numbers, or arrays by point."""

    value: Float[np.ndarray, " point"]
    gradient: Float[np.ndarray, "point variable"]
    hessian: Float[np.ndarray, "point variable variable"]

    # Arrays of NumPy leave operations with a jet to the jet.
    __array_ufunc__ = None

    def __add__(self, other: "Jet | Constant") -> "Jet":
        if isinstance(other, Jet):
            return Jet(
                self.value + other.value,
                self.gradient + other.gradient,
                self.hessian + other.hessian,
            )
        return Jet(self.value + other, self.gradient, self.hessian)

    __radd__ = __add__

    def __neg__(self) -> "Jet":
        return Jet(-self.value, -self.gradient, -self.hessian)

    def __sub__(self, other: "Jet | Constant") -> "Jet":
        if isinstance(other, Jet):
            return Jet(
                self.value - other.value,
                self.gradient - other.gradient,
                self.hessian - other.hessian,
            )
        return Jet(self.value - other, self.gradient, self.hessian)

    def __rsub__(self, other: Constant) -> "Jet":
        return -self + other

    def __mul__(self, other: "Jet | Constant") -> "Jet":
        if not isinstance(other, Jet):
            factor = np.asarray(other)
            return Jet(
                self.value * factor,
                self.gradient * factor[..., None],
                self.hessian * factor[..., None, None],
            )
        mixed = self.gradient[:, :, None] * other.gradient[:, None, :]
        hessian = self.value[:, None, None] * other.hessian
        hessian += other.value[:, None, None] * self.hessian
        hessian += mixed
        hessian += mixed.transpose(0, 2, 1)
        return Jet(
            self.value * other.value,
            self.value[:, None] * other.gradient + other.value[:, None] * self.gradient,
            hessian,
        )

    __rmul__ = __mul__

    def __truediv__(self, other: "Jet | Constant") -> "Jet":
        return self * (other**-1.0 if isinstance(other, Jet) else 1.0 / np.asarray(other))

    def __rtruediv__(self, other: Constant) -> "Jet":
        return self**-1.0 * other

    def __pow__(self, exponent: int | float) -> "Jet":
        first = exponent * self.value ** (exponent - 1.0)
        hessian = first[:, None, None] * self.hessian
        factor = exponent * (exponent - 1.0)
        # Of the first power there is no more, and x^-1 need not exist.
        if factor != 0.0:
            second = factor * self.value ** (exponent - 2.0)
            outer = self.gradient[:, :, None] * self.gradient[:, None, :]
            hessian += second[:, None, None] * outer
        return Jet(self.value**exponent, first[:, None] * self.gradient, hessian)


def variables(values: Float[np.ndarray, "variable point"]) -> list[Jet]:
    """The variables themselves, as jets of them."""
    count, points = values.shape
    none = np.zeros((points, count, count))
    unit = np.eye(count)
    return [
        Jet(value, np.broadcast_to(unit[i], (points, count)), none)
        for i, value in enumerate(values)
    ]
