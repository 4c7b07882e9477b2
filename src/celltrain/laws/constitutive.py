"""Constitutive laws: in-plane energy per unit of reference area.

A law is an energy density of the two strain invariants of the surface,

    I1 = tr(C) - 2,   I2 = det(C) - 1,   C = A^-1 a,

with A and a the metric tensors of the reference and the deformed surface; it is linear in each of
its moduli. Nothing else of the package depends on the law. Moduli are numbers, or arrays of JAX
where rates are differentiated by them; each has the name that it has in `parameters.Cell`.
"""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from celltrain.laws.arithmetic import Number


@runtime_checkable
class ConstitutiveLaw(Protocol):
    """In-plane elastic energy of a membrane: a dataclass whose fields are the moduli, in mu U."""

    def energy_density(self, first: Number, second: Number) -> Number:
        """Energy per reference area, in mu U, from the invariants I1 and I2."""
        ...


@dataclass(frozen=True)
class Skalak:
    """Red blood cell membrane, Eq. (1) of Bryngelson & Freund (2018), after Skalak et al. (1973).

    W = Es/8 (I1^2 + 2 I1 - 2 I2) + Ed/8 I2^2.
    """

    shear_modulus: Number
    dilatation_modulus: Number

    def energy_density(self, first: Number, second: Number) -> Number:
        """W(I1, I2) per reference area."""
        shear = self.shear_modulus / 8.0 * (first**2 + 2.0 * first - 2.0 * second)
        return shear + self.dilatation_modulus / 8.0 * second**2


@dataclass(frozen=True)
class NeoHookean:
    """Thin sheet of an incompressible neo-Hookean solid (Barthes-Biesel, Diaz & Dhenin 2002).

    W = Es/4 (I1 + 1/(1 + I2) - 1): at small strain it shears like `Skalak` with the same Es, and
    its dilatation follows from Es alone.
    """

    shear_modulus: Number

    def energy_density(self, first: Number, second: Number) -> Number:
        """W(I1, I2) per reference area."""
        return self.shear_modulus / 4.0 * (first + 1.0 / (1.0 + second) - 1.0)


#: The laws by their names in a case.
LAWS = {"skalak": Skalak, "neo_hookean": NeoHookean}
