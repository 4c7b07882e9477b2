"""How finely a simulation resolves the wall: it follows the cells' smallest distance from it.

The wall's modes decay from the wall as exp(-k d), so their number goes as the inverse square of the
smallest distance d to be served. The distance served is halved as soon as a cell is closer, and
doubled again once all are well beyond: a few steps in a whole simulation, each with a program of
its own to compile.
"""

from celltrain.evolution.ending import StepFailed

# Distances from the wall (r0) above this one cost about as much as this one.
LARGEST = 0.8
# At this one the wall's part takes most of the time, and 0.7 GiB more than at the largest.
SMALLEST = 0.1
# Coarser again when cells are this many times farther away than the coarser distance.
EASE = 1.5


def followed(served: float, distance: float) -> float:
    """The distance to be served next, from the one served so far and the cells' distance, in r0.

    **Raises:** `StepFailed` for a distance below `SMALLEST`.
    """
    if not distance >= SMALLEST:
        raise StepFailed(
            "near_wall",
            f"a cell is {distance:.3g} r0 from the wall, which is resolved for distances from"
            f" {SMALLEST:g} r0 on",
        )
    while served > SMALLEST and distance < served:
        served = max(0.5 * served, SMALLEST)
    while served < LARGEST and distance > 2.0 * EASE * served:
        served = min(2.0 * served, LARGEST)
    return served
