"""Results in r0, U and mu, or in SI in the units that people read."""

from dataclasses import dataclass

from celltrain.parameters import Scales
from celltrain.parameters.train import Units


@dataclass(frozen=True)
class Reading:
    """How numbers of a result are read: factors on them, and the names of their units."""

    units: Units
    scales: Scales

    @property
    def si(self) -> bool:
        """Whether it is in SI."""
        return self.units == "SI"

    def of(self, unit: str) -> tuple[float, str]:
        """Factor and name for a quantity in this unit of the package."""
        scales = self.scales
        if not self.si:
            names = {"U/r0": "U/r₀", "r0/U": "r₀/U", "r0": "r₀", "mu": "µ", "1": ""}
            return 1.0, names.get(unit, unit)
        known = {
            "U/r0": (1.0 / scales.time, "1/s"),
            "r0/U": (1e3 * scales.time, "ms"),
            "r0": (1e6 * scales.radius, "µm"),
            "U": (1e3 * scales.mean_velocity, "mm/s"),
            "mu": (1e3 * scales.plasma_viscosity, "mPa s"),
            "1": (1.0, ""),
        }
        return known[unit]

    @property
    def rate(self) -> float:
        """Factor on a rate in U/r0."""
        return self.of("U/r0")[0]

    @property
    def time(self) -> float:
        """Factor on a time in r0/U."""
        return self.of("r0/U")[0]
