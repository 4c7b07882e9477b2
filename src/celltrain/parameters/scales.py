"""The three SI scales that make a case dimensionless, and what they make of other quantities."""

from typing import Any

from pydantic import Field

from celltrain.parameters.section import Real, Section


class Scales(Section):
    """What r0, U and mu are in SI: 2.8 um, 2.875 mm/s and 1.2 mPa s unless given.

    They do not enter a dimensionless computation; results are reported in SI with them.
    """

    radius: Real = Field(
        default=2.8e-6, gt=0, description="radius r0 of the sphere of a cell's volume, m"
    )
    mean_velocity: Real = Field(
        default=2.875e-3, gt=0, description="mean velocity U in the tube, m/s"
    )
    plasma_viscosity: Real = Field(
        default=1.2e-3, gt=0, description="viscosity mu of the plasma, Pa s"
    )

    @property
    def time(self) -> float:
        """r0/U in s; a rate in U/r0 divided by this is in 1/s."""
        return self.radius / self.mean_velocity

    @property
    def surface_modulus(self) -> float:
        """mu U in N/m, the unit of the shear and the dilatation modulus."""
        return self.plasma_viscosity * self.mean_velocity

    @property
    def bending_modulus(self) -> float:
        """mu U r0^2 in N m, the unit of the bending modulus and of energies."""
        return self.surface_modulus * self.radius**2

    @property
    def pressure(self) -> float:
        """mu U/r0 in Pa."""
        return self.surface_modulus / self.radius

    def unit(self, leaf: str) -> float | None:
        """The SI value of 1 for a leaf that has a dimension, otherwise None."""
        units: dict[str, float] = {
            "diameter": self.radius,
            "shear_modulus": self.surface_modulus,
            "dilatation_modulus": self.surface_modulus,
            "bending_modulus": self.bending_modulus,
            "spontaneous_curvature": 1 / self.radius,
        }
        return units.get(leaf)

    def dimensionless(self, leaf: str, value: Any) -> Any:
        """An SI value in r0, U, mu; what is not a number is left for the validation to refuse."""
        unit = self.unit(leaf)
        if unit is None or isinstance(value, bool) or not isinstance(value, int | float):
            return value
        return value / unit

    def si(self, leaf: str, value: Any) -> Any:
        """A value in r0, U, mu as its SI value: the inverse of :meth:`dimensionless`."""
        unit = self.unit(leaf)
        return value if unit is None else value * unit
