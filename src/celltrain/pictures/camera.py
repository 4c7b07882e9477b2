"""A camera beside the tube: flow from left to right, with slight perspective."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float


@dataclass(frozen=True)
class Camera:
    """Perspective projection onto a plane through `target`.

    Attributes:
        target: the point (r0) shown at the origin of the picture.
        distance: of the eye from the target (r0); larger is flatter.
        yaw: angle (radians) by which the eye moves upstream, so that the rear of a cell shows.
        elevation: angle (radians) by which the eye is raised.
    """

    target: Float[np.ndarray, "3"]
    distance: float
    yaw: float = np.deg2rad(25.0)
    elevation: float = np.deg2rad(7.0)

    @property
    def backward(self) -> Float[np.ndarray, "3"]:
        """Unit vector from the target to the eye."""
        level = np.cos(self.elevation)
        return np.array(
            [-level * np.cos(self.yaw), np.sin(self.elevation), -level * np.sin(self.yaw)]
        )

    @property
    def right(self) -> Float[np.ndarray, "3"]:
        """Unit vector to the right of the picture."""
        across = np.cross([0.0, 1.0, 0.0], self.backward)
        return across / np.linalg.norm(across)

    @property
    def up(self) -> Float[np.ndarray, "3"]:
        """Unit vector to the top of the picture."""
        return np.cross(self.backward, self.right)

    @property
    def eye(self) -> Float[np.ndarray, "3"]:
        """Position of the eye (r0)."""
        return self.target + self.distance * self.backward

    def project(
        self, points: Float[np.ndarray, "*any 3"]
    ) -> tuple[Float[np.ndarray, "*any 2"], Float[np.ndarray, "*any"]]:
        """Picture coordinates (r0 at the target's depth) and depth (larger is nearer)."""
        relative = points - self.target
        depth = np.asarray(relative @ self.backward)
        flat = np.stack([relative @ self.right, relative @ self.up], axis=-1)
        return flat * (self.distance / (self.distance - depth))[..., None], depth
