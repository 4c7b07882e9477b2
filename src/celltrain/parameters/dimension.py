"""What the numbers of a case are measured in, and how formulas call them.

Both stand with the field of a section that they belong to:

    shear_modulus: Annotated[Real, SURFACE_MODULUS, Symbol("E_s")] = Field(...)

Conversion from and to SI, the strength of the flow as a parameter of its own, options and their
documentation, and the axes of pictures take them from there.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Dimension:
    """Powers of mu, U and r0 that a number is a multiple of, and its unit in SI.

    A power of U makes the number, dimensionless, depend on the strength of the flow.
    """

    si: str
    viscosity: int = 0
    velocity: int = 0
    length: int = 0

    @property
    def unit(self) -> str:
        """Its unit inside the package, such as ``"mu U r0^2"``; ``"1"`` for a pure number."""
        powers = (("mu", self.viscosity), ("U", self.velocity), ("r0", self.length))
        above = [_power(name, power) for name, power in powers if power > 0]
        below = [_power(name, -power) for name, power in powers if power < 0]
        return "/".join([" ".join(above) or "1", *below])


@dataclass(frozen=True)
class Symbol:
    """How formulas call a number, in LaTeX without dollars."""

    text: str


#: A pure number.
NUMBER = Dimension("1")
LENGTH = Dimension("m", length=1)
CURVATURE = Dimension("1/m", length=-1)
#: Force per length: energy for each area of a membrane.
SURFACE_MODULUS = Dimension("N/m", viscosity=1, velocity=1)
#: An energy.
BENDING_MODULUS = Dimension("N m", viscosity=1, velocity=1, length=2)


def _power(name: str, power: int) -> str:
    return name if power == 1 else f"{name}^{power}"
