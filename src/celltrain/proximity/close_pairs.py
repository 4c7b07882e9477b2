"""Which targets are too close to which cells for an ordinary grid.

The smallest distance from every target to the grid points of every cell and periodic image is
found chunk by chunk, as the near sums are taken; cells whose points' bounding box is out of reach
of a chunk's are skipped. What is close is listed, up to a given number of pairs, and counted beyond
it.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

TARGET_CHUNK = 64
PAIR_CHUNK = 64


class ClosePairs(eqx.Module):
    """Pairs of a target and the image of a cell, and the mask of what is left to ordinary sums.

    `image` is p of a source displaced by p * period along the tube, from -images to images; `node`
    the number of the cell's grid point nearest to the target. Entries that are not `valid` are
    padding. `count` is the number of all close pairs: the list is complete only if `overflow` is
    false. `keep` is false for the close pairs, listed or not.
    """

    image: Int[Array, " pair"]
    group: Int[Array, " pair"]
    target: Int[Array, " pair"]
    cell: Int[Array, " pair"]
    node: Int[Array, " pair"]
    valid: Bool[Array, " pair"]
    count: Int[Array, ""]
    keep: Bool[Array, "image group target cell"]

    @property
    def overflow(self) -> Bool[Array, ""]:
        """Whether there are more close pairs than listed."""
        return self.count > self.valid.size

    def points(
        self, targets: Float[Array, "group target 3"], period: Float[Array, ""] | float
    ) -> Float[Array, "pair 3"]:
        """Target of each pair, displaced as if the cell's image were the cell itself."""
        chosen = targets[self.group, self.target]
        return chosen - jnp.array([0.0, 0.0, 1.0]) * (self.image * period)[:, None]


def close_pairs(
    targets: Float[Array, "group target 3"],
    owners: Int[Array, " group"],
    sources: Float[Array, "cell source 3"],
    *,
    distance: float,
    period: Float[Array, ""] | float,
    images: int,
    capacity: int,
) -> ClosePairs:
    """Pairs whose target is less than `distance` (r0) from a grid point of an image of a cell.

    The cell's surface may come closer than its grid points, by little if `distance` is well above
    their spacing. Derivatives do not pass through.

    A grid of order q (q rings) integrates a single layer to 1e-6 of the largest velocity beyond
    2.2 h, and a double layer beyond 3.5 h, where h = pi/q times the largest stretch of the surface
    (1.4 r0): measured on biconcave and deformed cells for q = 30, 36 (M = 12) and 40 (M = 16), with
    densities whose coefficients fall as (1 + n)^-2. For 1e-7 it is 2.8 h in the single layer, and
    with all degrees alike 3.0 h and 3.8 h.

    **Arguments:** `owners`: the cell on which each group of targets lies, -1 for none; it is not
    paired with its own targets, but its images are. `capacity`: the length of the list.
    """
    targets, sources = jax.lax.stop_gradient((targets, sources))
    period = jax.lax.stop_gradient(jnp.asarray(period))
    shape = (2 * images + 1, *targets.shape[:2], sources.shape[0])
    square = _least_squares(targets, sources, distance=distance, period=period, images=images)
    own = owners[:, None] == jnp.arange(shape[3])
    own = own & (jnp.arange(-images, images + 1) == 0)[:, None, None]
    close = (square < distance**2) & ~own[:, :, None]
    count = jnp.sum(close)
    place = jnp.nonzero(close.ravel(), size=capacity, fill_value=0)[0]
    image, group, target, cell = jnp.unravel_index(place, shape)
    valid = jnp.arange(capacity) < count
    image = image - images
    shifted = targets[group, target] - jnp.array([0.0, 0.0, 1.0]) * (image * period)[:, None]
    return ClosePairs(
        image=image,
        group=group,
        target=target,
        cell=cell,
        node=_nearest_nodes(shifted, cell, sources, jnp.minimum(count, capacity)),
        valid=valid,
        count=count,
        keep=~close,
    )


def _least_squares(
    targets: Float[Array, "group target 3"],
    sources: Float[Array, "cell source 3"],
    *,
    distance: float,
    period: Float[Array, ""],
    images: int,
) -> Float[Array, "image group target cell"]:
    """Squared distance to the nearest grid point; infinite where a chunk is out of reach."""
    groups, count, _ = targets.shape
    chunks = -(-count // TARGET_CHUNK)
    padding = ((0, 0), (0, chunks * TARGET_CHUNK - count), (0, 0))
    # Padding repeats the last target of the group: harmless for the chunk's extent.
    padded = jnp.pad(targets, padding, mode="edge").reshape(-1, TARGET_CHUNK, 3)
    cells = jnp.arange(sources.shape[0])
    low, high = jnp.min(sources, axis=1), jnp.max(sources, axis=1)
    up = jnp.array([0.0, 0.0, 1.0])

    def of_chunk(points: Float[Array, "target 3"]) -> Float[Array, "image cell target"]:
        def of_image(shift: Int[Array, ""]) -> Float[Array, "cell target"]:
            moved = points - up * (shift * period)
            bottom, top = jnp.min(moved, axis=0), jnp.max(moved, axis=0)

            def of_cell(cell: Int[Array, ""]) -> Float[Array, " target"]:
                gap = jnp.maximum(jnp.maximum(low[cell] - top, bottom - high[cell]), 0.0)

                def least(moved: Array) -> Array:
                    d = [moved[:, i, None] - sources[cell, :, i] for i in range(3)]
                    return jnp.min(d[0] ** 2 + d[1] ** 2 + d[2] ** 2, axis=1)

                def out_of_reach(moved: Array) -> Array:
                    return jnp.full_like(moved[:, 0], jnp.inf)

                return jax.lax.cond(jnp.sum(gap**2) < distance**2, least, out_of_reach, moved)

            return jax.lax.map(of_cell, cells)

        return jax.lax.map(of_image, jnp.arange(-images, images + 1))

    found = jax.lax.map(of_chunk, padded)
    found = found.reshape(groups, chunks, 2 * images + 1, cells.size, TARGET_CHUNK)
    found = jnp.transpose(found, (2, 0, 1, 4, 3))
    return found.reshape(2 * images + 1, groups, -1, cells.size)[:, :, :count]


def _nearest_nodes(
    points: Float[Array, "pair 3"],
    cells: Int[Array, " pair"],
    sources: Float[Array, "cell source 3"],
    count: Int[Array, ""],
) -> Int[Array, " pair"]:
    """Number of the cell's grid point nearest to each of the first `count` points."""

    def add(number: Array, found: Array) -> Array:
        pair = jnp.minimum(PAIR_CHUNK * number + jnp.arange(PAIR_CHUNK), count - 1)
        d = points[pair, None] - sources[cells[pair]]
        return found.at[pair].set(jnp.argmin(jnp.sum(d * d, axis=-1), axis=1))

    start = jnp.zeros(points.shape[0], dtype=cells.dtype)
    return jax.lax.fori_loop(0, -(-count // PAIR_CHUNK), add, start)
