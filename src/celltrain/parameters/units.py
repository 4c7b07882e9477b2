"""The conversion to the numbers that the paper prints.

Inside the package lengths are in r0 (radius of the sphere of a cell's volume), velocities in U
(mean velocity in the tube) and viscosities in mu (plasma); hence rates in U/r0, forces per length
in mu U. Two statements of Bryngelson & Freund (2018) do not fit that, nor each other:

*Capillary number.* Ca = mu U/Es is 0.82 with the paper's U = 2.875 mm/s. Its nominal "Ca = 0.66"
takes the velocity 2.3 mm/s instead, the mean over the square box of side D + 0.5 in which it
computes, and so does the Ca axis of its figures: Ca_paper = 0.8 Ca.

*Time.* The paper gives rates in U/r0, but its numbers are in U*/r0 with U* = U/10, the unit of
velocity of its code, in which the mean velocity is 10. With its own parameters the growth rates,
the numerical abscissas and the times to breakup all differ from the printed ones by ten; and its
distances travelled, "1.4e5 r0" for a rate of 1e-3, need a centreline velocity of 20. So
alpha_paper = 10 alpha, eta_paper = 10 eta, t_paper = t/10.

Results are always in U/r0; :data:`paper_units` is the one place where they become comparable with
printed numbers.
"""

from dataclasses import dataclass
from typing import TypeVar

import numpy as np

Number = TypeVar("Number", float, np.ndarray)


@dataclass(frozen=True)
class PaperUnits:
    """Conversion between this package's numbers and those that the paper prints.

    Takes and returns floats or arrays. See the module's docstring for the evidence.
    """

    #: The paper's unit of velocity over the mean velocity, U*/U.
    velocity: float = 0.1
    #: The velocity in the paper's capillary number over the mean velocity, U^/U.
    capillary_velocity: float = 0.8

    def rate(self, rate: Number) -> Number:
        """A growth rate, frequency or numerical abscissa in U/r0 as the paper prints it."""
        return rate / self.velocity

    def rate_from_paper(self, rate: Number) -> Number:
        """A printed rate in U/r0."""
        return rate * self.velocity

    def time(self, time: Number) -> Number:
        """A time in r0/U as the paper prints it."""
        return time * self.velocity

    def time_from_paper(self, time: Number) -> Number:
        """A printed time in r0/U."""
        return time / self.velocity

    def capillary_number(self, capillary_number: Number) -> Number:
        """Ca = mu U/Es as the paper prints it."""
        return capillary_number * self.capillary_velocity

    def capillary_number_from_paper(self, capillary_number: Number) -> Number:
        """A printed capillary number as mu U/Es."""
        return capillary_number / self.capillary_velocity


#: The one conversion between this package's numbers and the paper's.
paper_units = PaperUnits()
