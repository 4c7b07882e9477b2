"""Degrees that rise until a number is known, and what a sequence of them leaves open.

A number x(M) converges faster than any power of 1/M once the degree M follows the shape, but not
evenly: single changes may be small by chance. So what is left after the last degree is judged by
the last `CHANGES` changes d_i = |x_i - x_(i-1)|, each carried on at the rate at which they are seen
to fall, but at none better than `BEST_RATE` and none worse than `WORST_RATE` from one degree to the
next,

    left = rate/(1 - rate) max_i (d_i rate^(last - i)).

Three degrees are the fewest that tell.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated

from celltrain.quantities import Quantity
from celltrain.steady.base import MembraneCrosses, NotConverged

#: The degrees that are tried, one after another.
DEGREES = (12, 16, 20, 24, 32, 40, 48, 56, 64)
BEST_RATE, WORST_RATE = 0.3, 0.7
CHANGES = 3
#: What the last shape of a search leaves out of the velocity (U) where no degree would change it.
RESOLVED = 3e-5
#: Fewest degrees whose changes tell what is left.
FEWEST = 3


@dataclass(frozen=True)
class Convergence:
    """A number at several degrees, and which of them is taken; in the number's own unit.

    `least` is the smallest error that is stated, as the smallest changes are also chance.
    """

    degree: Annotated[int, Quantity("M", "1", "degree that is taken")]
    degrees: Annotated[
        tuple[int, ...], Quantity("M", "1", "degrees at which the number was computed")
    ] = ()
    values: Annotated[
        tuple[float, ...], Quantity("", "U/r0", "the growth rate at these degrees")
    ] = ()
    least: Annotated[float, Quantity("", "U/r0", "the smallest error that is stated")] = 0.0

    @property
    def left(self) -> float:
        """What the last degree leaves open; NaN from a single degree."""
        return max(remaining(self.values), self.least) if len(self.values) > 1 else math.nan

    @property
    def error(self) -> float:
        """The error at the degree that is taken, by what the others tell."""
        if len(self.values) < 2:
            return math.nan
        return abs(self.values[self.degrees.index(self.degree)] - self.values[-1]) + self.left


def remaining(values: Sequence[float]) -> float:
    """What a sequence leaves open (see the module); NaN for one value alone."""
    changes = [abs(b - a) for a, b in pairwise(values)]
    if not changes:
        return math.nan
    last = len(changes) - 1
    rates = [b / a for a, b in pairwise(changes) if a > 0.0]
    rate = min(max(rates[-1], BEST_RATE), WORST_RATE) if rates else WORST_RATE
    recent = range(max(0, last + 1 - CHANGES), last + 1)
    envelope = max(changes[place] * rate ** (last - place) for place in recent)
    return envelope * rate / (1.0 - rate)


def higher(degree: int) -> tuple[int, ...]:
    """The degrees of the ladder above one."""
    return tuple(each for each in DEGREES if each > degree)


def raised(
    evaluate: Callable[[int], float],
    enough: Callable[[Convergence], bool],
    *,
    first: int = DEGREES[0],
    least: float = 0.0,
) -> Convergence:
    """The degree raised from `first` until the values are enough, or there is none higher.

    Degrees that are too low for there to be a train are passed over, unless the shape at which the
    search ended is resolved, so that a higher one would end there too; one that fails above others
    ends the sequence, unless its train is one that cells cannot have: then they cannot have that of
    a lower degree either.

    **Raises:** `NotConverged` if there is a value at none; what else `evaluate` raises.
    """
    degrees: tuple[int, ...] = ()
    values: tuple[float, ...] = ()
    ladder = (first, *higher(first))
    for degree in ladder:
        try:
            value = evaluate(degree)
        except NotConverged as failure:
            crosses = isinstance(failure, MembraneCrosses)
            if values and not crosses:
                break
            if values or degree == ladder[-1] or failure.last.truncation_error < RESOLVED:
                raise
            continue
        degrees, values = (*degrees, degree), (*values, value)
        found = Convergence(degree, degrees, values, least)
        if len(values) >= FEWEST and enough(found):
            break
    return found
