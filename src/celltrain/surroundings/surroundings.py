"""The one object that knows what is around the cells.

The operator, simulations, films and checks of overlaps ask it, and nothing else of theirs knows a
radius or a wall. Another vessel is a class of its own here, with its `Wall` (`proximity.walls`) and
its `SurroundingFlow` (`flow`).
"""

import abc
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from celltrain.flow import SurroundingFlow
from celltrain.flow.close_targets import CloseEvaluation
from celltrain.proximity.walls import NoWall, Wall


@dataclass(frozen=True)
class FlowRules:
    """How accurately a flow is computed.

    Attributes:
        near_cutoff: range of the near kernel where there is a far one, r0.
        tolerance: relative error of sums that are truncated.
        wall_gap: smallest distance of a cell from the wall for which the wall is resolved, r0.
        extent: how far a cell may reach along z from its centre, r0.
        close: makes what serves targets close to a cell, from xi of the near kernel; None if there
            are no such targets.
        near_wall: whether cells may be that close to the wall.
        coarse_beyond: distance from a cell at which its coarse samples serve, r0.
    """

    near_cutoff: float
    tolerance: float
    wall_gap: float
    extent: float
    close: Callable[[float], CloseEvaluation] | None
    near_wall: bool
    coarse_beyond: float


class Surroundings(abc.ABC):
    """What bounds the fluid, how it flows without cells, and by what everything recurs."""

    @property
    @abc.abstractmethod
    def wall(self) -> Wall:
        """What bounds the fluid."""

    @property
    @abc.abstractmethod
    def period(self) -> float:
        """By what all cells are displaced along z to their images, r0; infinite without images."""

    @abc.abstractmethod
    def flow(self, rules: FlowRules) -> SurroundingFlow:
        """The flow around cells, for the operator."""

    @property
    def empty(self) -> bool:
        """Whether a single cell has nothing else around it, neither a wall nor images."""
        return not self.recurs and isinstance(self.wall, NoWall)

    @property
    def recurs(self) -> bool:
        """Whether cells have images."""
        return math.isfinite(self.period)

    def wall_distance(self, points: Float[np.ndarray, "*set 3"]) -> float:
        """Smallest distance of all the points from the wall, in r0, negative beyond it."""
        return float(np.min(self.wall.distance(points)))
