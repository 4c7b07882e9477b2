"""What a simulation starts from: a steady train, and its modes, at the degree of the simulation.

A simulation costs much more at a higher degree than the steady train and its linear dynamics do, so
it has a degree of its own, and these are computed anew where theirs is another.
"""

from celltrain.parameters import Train
from celltrain.stability import Stability, stability
from celltrain.steady import Base, steady

#: Degree of a simulation unless another one is given.
DEGREE = 12


def at_degree(start: Train | Base | Stability, degree: int | None) -> Base | Stability:
    """The steady train, with its linear dynamics unless `start` lacks them, at a degree.

    **Arguments:** `degree`: if not given, that of a case which gives one, and `DEGREE` otherwise.

    **Raises:** `NotConverged` if there is no such train, `CaseError` for a degree that is not
    allowed.
    """
    if isinstance(start, Train):
        chosen = start.resolution.degree if degree is None else degree
        train = start.changed(degree=DEGREE if chosen is None else chosen)
        return stability(train, estimate_error=False)
    base = start.base if isinstance(start, Stability) else start
    chosen = DEGREE if degree is None else degree
    if base.train.degree == chosen:
        return start
    other = steady(base.train.changed(degree=chosen), start=base, estimate_error=False)
    if isinstance(start, Base):
        return other
    numbers = [m for m in start.azimuthal_numbers if m <= chosen]
    whole = len(start.azimuthal_numbers) == base.train.degree + 1
    return stability(other, azimuthal_numbers=None if whole else numbers, estimate_error=False)
