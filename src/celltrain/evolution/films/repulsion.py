"""The short-range repulsion of membranes, by which a simulation goes on where films get thin.

Red cells keep apart by the layer of sugars that they carry (the glycocalyx; Neu & Meiselman 2002)
and the film of plasma that it holds. Lubrication forces do the same in theory, but the velocity of
a membrane has finitely many harmonics: below a gap of a few hundredths of r0 it cannot follow the
film's flow, and membranes would pass through each other. The repulsion stands for what is not
resolved. It has an energy for each area of a film of thickness d,

    phi(d) = S (1 - d/a)^3/(d/a)  for 0 < d < a,   0 for d >= a,   infinite for d <= 0,

with the strength S and the range a: zero with its first two derivatives at the range, and more than
any force can overcome as the gap closes. Beyond the range it is absent altogether.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from jaxtyping import Float

from celltrain.parameters import CaseError
from celltrain.quantities import Quantity

# Range, r0: 70 nm.
RANGE = 0.025
LARGEST_RANGE = 0.2
# Strength, mu U: 3.5e-7 J/m^2 with the paper's viscosity and velocity.
STRENGTH = 0.1


@dataclass(frozen=True)
class Repulsion:
    """Range and strength of the repulsion between membranes, and between them and the wall.

    **Raises:** `CaseError` for numbers that are not allowed.
    """

    range: Annotated[
        float, Quantity("a", "r0", "thickness of the films within which it acts, 0: never")
    ] = RANGE
    strength: Annotated[float, Quantity("S", "mu U", "energy scale for each area of the film")] = (
        STRENGTH
    )

    def __post_init__(self) -> None:
        if not 0.0 <= self.range <= LARGEST_RANGE:
            raise CaseError(
                f"repulsion_range = {self.range!r} is not allowed; allowed: 0 (none) to"
                f" {LARGEST_RANGE:g} r0"
            )
        if not (np.isfinite(self.strength) and self.strength > 0.0):
            raise CaseError(
                f"repulsion_strength = {self.strength!r} is not allowed; allowed: a number > 0"
                " (repulsion_range = 0 switches the repulsion off)"
            )

    def energy_density(self, gap: Float[np.ndarray, "..."]) -> Float[np.ndarray, "..."]:
        """Energy phi(d) for each area of a film, mu U."""
        ratio = self._ratio(gap)
        return self.strength * (1.0 - ratio) ** 3 / ratio

    def pressure(self, gap: Float[np.ndarray, "..."]) -> Float[np.ndarray, "..."]:
        """-dphi/dd = (S/a) (1 - d/a)^2 (1 + 2 d/a)/(d/a)^2, mu U/r0."""
        ratio = self._ratio(gap)
        return self.strength / self.range * (1.0 - ratio) ** 2 * (1.0 + 2.0 * ratio) / ratio**2

    def _ratio(self, gap: Float[np.ndarray, "..."]) -> Float[np.ndarray, "..."]:
        """d/a, 1 beyond the range; positive gaps only."""
        return np.minimum(gap / self.range, 1.0)
