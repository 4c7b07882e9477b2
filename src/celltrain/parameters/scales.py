"""The three SI scales that make a case dimensionless, and what they make of other quantities."""

from typing import Annotated, overload

from pydantic import Field

from celltrain.parameters.dimension import Dimension, Symbol
from celltrain.parameters.section import Real, Section


class Scales(Section):
    """What r0, U and mu are in SI: 2.8 um, 2.875 mm/s and 1.2 mPa s unless given.

    They do not enter a dimensionless computation; results are reported in SI with them.
    """

    radius: Annotated[Real, Dimension("m"), Symbol("r_0")] = Field(
        default=2.8e-6, gt=0, description="radius r0 of the sphere of a cell's volume, m"
    )
    mean_velocity: Annotated[Real, Dimension("m/s"), Symbol("U")] = Field(
        default=2.875e-3, gt=0, description="mean velocity U in the tube, m/s"
    )
    plasma_viscosity: Annotated[Real, Dimension("Pa s"), Symbol(r"\mu")] = Field(
        default=1.2e-3, gt=0, description="viscosity mu of the plasma, Pa s"
    )

    @property
    def time(self) -> float:
        """r0/U in s; a rate in U/r0 divided by this is in 1/s."""
        return self.radius / self.mean_velocity

    @property
    def pressure(self) -> float:
        """mu U/r0 in Pa."""
        return self.plasma_viscosity * self.mean_velocity / self.radius

    def unit(self, dimension: Dimension) -> float:
        """The SI value of 1 of a dimension."""
        viscosity = self.plasma_viscosity**dimension.viscosity
        return viscosity * self.mean_velocity**dimension.velocity * self.radius**dimension.length

    @overload
    def dimensionless(self, dimension: Dimension, value: float) -> float: ...
    @overload
    def dimensionless(self, dimension: Dimension, value: object) -> object: ...
    def dimensionless(self, dimension: Dimension, value: object) -> object:
        """An SI value in r0, U, mu; what is not a number is left for the validation to refuse."""
        if isinstance(value, bool) or not isinstance(value, int | float):
            return value
        unit = self.unit(dimension)
        return value if unit == 1.0 else value / unit

    @overload
    def si(self, dimension: Dimension, value: float) -> float: ...
    @overload
    def si(self, dimension: Dimension, value: object) -> object: ...
    def si(self, dimension: Dimension, value: object) -> object:
        """A value in r0, U, mu as its SI value: the inverse of :meth:`dimensionless`."""
        unit = self.unit(dimension)
        return value * unit if unit != 1.0 and isinstance(value, int | float) else value


#: The scales at which the defaults of a case are those of a red blood cell.
REFERENCE = Scales()
