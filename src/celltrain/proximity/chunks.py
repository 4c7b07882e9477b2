"""Targets in chunks of one size with all their images, for sums over what is near to each chunk.

What is near is found between boxes: those of a chunk's points, and those of sets of points. A chunk
is moved by an image's number of periods against z, as if all sets stayed where they are.
"""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

CHUNK = 32


class Chunks(eqx.Module):
    """Chunks of groups of targets, [chunk, target], and the cell on which each lies, or -1.

    Each group's last chunk is filled up with the group's last target, which leaves its box as it
    is. `count` is the number of targets of a group, `images` go from -`images` to `images`.
    """

    points: Float[Array, "chunk target 3"]
    owners: Int[Array, " chunk"]
    period: Float[Array, ""]
    count: int = eqx.field(static=True)
    images: int = eqx.field(static=True)

    @property
    def by_group(self) -> int:
        """Number of chunks of each group."""
        return -(-self.count // CHUNK)

    @property
    def shifts(self) -> Int[Array, " image"]:
        """Numbers of the images."""
        return jnp.arange(-self.images, self.images + 1)

    @property
    def moved(self) -> Float[Array, "image chunk target 3"]:
        """The points as they stand to the images of what does not move."""
        along = jnp.array([0.0, 0.0, 1.0]) * self.period
        return self.points - self.shifts[:, None, None, None] * along

    @property
    def filling(self) -> Bool[Array, "chunk target"]:
        """Which points only fill up the last chunk of a group."""
        place = jnp.arange(self.by_group * CHUNK) >= self.count
        groups = self.points.shape[0] // self.by_group
        return jnp.tile(place.reshape(self.by_group, CHUNK), (groups, 1))

    def distance(self, sets: Float[Array, "set point 3"]) -> Float[Array, "image chunk set"]:
        """Between the boxes of chunks and of sets of points, in r0."""
        moved = self.moved
        low, high = jnp.min(moved, axis=2)[:, :, None], jnp.max(moved, axis=2)[:, :, None]
        gap = jnp.maximum(low - jnp.max(sets, axis=1), jnp.min(sets, axis=1) - high)
        return jnp.linalg.norm(jnp.maximum(gap, 0.0), axis=-1)

    def own(self, cells: Int[Array, " set"]) -> Bool[Array, "image chunk set"]:
        """Where a set is part of the cell itself, no image, on which a chunk lies."""
        return (self.owners[:, None] == cells) & (self.shifts == 0)[:, None, None]

    def in_groups(self, values: Float[Array, "chunk place 3"]) -> Float[Array, "group target 3"]:
        """Values of the chunks as those of the groups they were made from."""
        return values.reshape(-1, self.by_group * CHUNK, 3)[:, : self.count]


def chunks_of(
    targets: Float[Array, "group target 3"],
    owners: Int[Array, " group"],
    *,
    period: Float[Array, ""] | float,
    images: int,
) -> Chunks:
    """Chunks of targets; `owners`: the cell on which each group lies, -1 for none."""
    count = targets.shape[1]
    by_group = -(-count // CHUNK)
    padding = ((0, 0), (0, by_group * CHUNK - count), (0, 0))
    padded = jnp.pad(targets, padding, mode="edge").reshape(-1, CHUNK, 3)
    return Chunks(padded, jnp.repeat(owners, by_group), jnp.asarray(period), count, images)
