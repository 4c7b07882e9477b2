"""A straight round tube, periodic along its axis, with the flow at a given rate."""

import math
from dataclasses import dataclass

from celltrain.flow import PeriodicTube, periodic_tube
from celltrain.parameters import CaseError, Train
from celltrain.proximity.walls import RoundWall
from celltrain.surroundings.surroundings import FlowRules, Surroundings


@dataclass(frozen=True)
class RoundTube(Surroundings):
    """A tube about the axis z, with the mean velocity U e_z.

    `radius` is that of the tube, `length` what everything recurs by, both in r0.

    **Raises:** `CaseError` for numbers that are not positive and finite.
    """

    radius: float
    length: float

    def __post_init__(self) -> None:
        for name in ("radius", "length"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise CaseError(f"{name} = {value!r} is not allowed; allowed: a number > 0, in r0")

    @property
    def wall(self) -> RoundWall:
        """See `Surroundings`."""
        return RoundWall(self.radius)

    @property
    def period(self) -> float:
        """See `Surroundings`."""
        return self.length

    def flow(self, rules: FlowRules) -> PeriodicTube:
        """See `Surroundings`."""
        return periodic_tube(
            2.0 * self.radius,
            self.length,
            wall_gap=rules.wall_gap,
            extent=rules.extent,
            cutoff=rules.near_cutoff,
            tolerance=rules.tolerance,
            close=rules.close,
            near_wall=rules.near_wall,
            coarse_beyond=rules.coarse_beyond,
        )


def train_tube(train: Train, cells: int | None = None) -> RoundTube:
    """The tube of a train, periodic over `cells` cells; over all of them unless given."""
    count = train.cells if cells is None else cells
    return RoundTube(train.radius, count * train.period)
