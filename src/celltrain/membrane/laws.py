"""Constitutive laws: in-plane energy per unit of reference area.

A law is an energy density of the two strain invariants of the surface,

    I1 = tr(C) - 2,   I2 = det(C) - 1,   C = A^-1 a,

with A and a the metric tensors of the reference and the deformed surface. Nothing else of the
package depends on the law.
"""

import abc

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float


class ConstitutiveLaw(eqx.Module):
    """In-plane elastic energy of a membrane."""

    @abc.abstractmethod
    def energy_density(
        self, first: Float[Array, " point"], second: Float[Array, " point"]
    ) -> Float[Array, " point"]:
        """Energy per reference area, in mu U, from the invariants I1 and I2."""


class Skalak(ConstitutiveLaw):
    """Red blood cell membrane, Eq. (1) of Bryngelson & Freund (2018), after Skalak et al. (1973).

    W = Es/8 (I1^2 + 2 I1 - 2 I2) + Ed/8 I2^2.
    """

    shear_modulus: Float[Array, ""]
    dilatation_modulus: Float[Array, ""]

    def energy_density(
        self, first: Float[Array, " point"], second: Float[Array, " point"]
    ) -> Float[Array, " point"]:
        """W(I1, I2) per reference area."""
        shear = self.shear_modulus / 8.0 * (first**2 + 2.0 * first - 2.0 * second)
        return shear + self.dilatation_modulus / 8.0 * second**2


class NeoHookean(ConstitutiveLaw):
    """Thin sheet of an incompressible neo-Hookean solid (Barthes-Biesel, Diaz & Dhenin 2002).

    W = Es/4 (I1 + 1/(1 + I2) - 1): at small strain it shears like `Skalak` with the same Es, and
    its dilatation follows from Es alone.
    """

    shear_modulus: Float[Array, ""]

    def energy_density(
        self, first: Float[Array, " point"], second: Float[Array, " point"]
    ) -> Float[Array, " point"]:
        """W(I1, I2) per reference area."""
        return self.shear_modulus / 4.0 * (first + 1.0 / (1.0 + second) - 1.0)


def make_law(
    name: str,
    shear_modulus: float | Float[Array, ""],
    dilatation_modulus: float | Float[Array, ""],
) -> ConstitutiveLaw:
    """The law of the given name; `KeyError` if there is none."""
    shear = jnp.asarray(shear_modulus, dtype=float)
    laws = {
        "skalak": lambda: Skalak(shear, jnp.asarray(dilatation_modulus, dtype=float)),
        "neo_hookean": lambda: NeoHookean(shear),
    }
    return laws[name]()
