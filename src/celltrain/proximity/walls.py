"""What bounds the fluid, as far as distances from it go; which flow it makes `flow` knows."""

import abc
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float


class Wall(abc.ABC):
    """The boundary of the fluid, on one side of which the cells are."""

    @abc.abstractmethod
    def distance(self, points: Float[np.ndarray, "*set 3"]) -> Float[np.ndarray, "*set"]:
        """Distance of points from the wall, in r0, negative beyond it; infinite without one."""

    @abc.abstractmethod
    def inward(self, points: Float[np.ndarray, "*set 3"]) -> Float[np.ndarray, "*set 3"]:
        """Unit vectors away from the wall, from the point of it that is nearest to each point."""


@dataclass(frozen=True)
class RoundWall(Wall):
    """The wall of a straight round tube about the axis z, of a radius in r0."""

    radius: float

    def distance(self, points: Float[np.ndarray, "*set 3"]) -> Float[np.ndarray, "*set"]:
        """See `Wall`."""
        return self.radius - np.hypot(points[..., 0], points[..., 1])

    def inward(self, points: Float[np.ndarray, "*set 3"]) -> Float[np.ndarray, "*set 3"]:
        """See `Wall`; points on the axis have no such direction."""
        found = np.zeros(points.shape)
        axial = np.hypot(points[..., 0], points[..., 1])
        found[..., :2] = -points[..., :2] / axial[..., None]
        return found


@dataclass(frozen=True)
class NoWall(Wall):
    """No wall: everything is infinitely far from it."""

    def distance(self, points: Float[np.ndarray, "*set 3"]) -> Float[np.ndarray, "*set"]:
        """See `Wall`."""
        return np.full(points.shape[:-1], np.inf)

    def inward(self, points: Float[np.ndarray, "*set 3"]) -> Float[np.ndarray, "*set 3"]:
        """See `Wall`; no direction, zeros."""
        return np.zeros(points.shape)
