"""Which targets are too close to which cells for an ordinary grid.

The smallest distance from every target to the grid points of every cell and periodic image is
found for those pairs of a chunk of targets and an image of a cell whose boxes are within reach.
These pairs are listed, and of them what is close, both up to a given number.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from celltrain.proximity.chunks import CHUNK, Chunks, chunks_of

PAIR_CHUNK = 64
# Pairs of a chunk and an image of a cell that are looked at together.
ROWS_AT_ONCE = 4
# As many of them are listed for each chunk, on average; dense trains far off the axis had two.
ROWS_PER_CHUNK = 12


class LeftOut(eqx.Module):
    """What is left out of ordinary sums: close pairs, in rows of a chunk and an image of a cell.

    `rows` has the number of the row that a chunk and an image of a cell have, -1 where there is
    none, and with it nothing close. A row is true where the chunk's target is close to that cell.
    """

    rows: Int[Array, "image chunk cell"]
    close: Bool[Array, "row target"]


class ClosePairs(eqx.Module):
    """Pairs of a target and the image of a cell, and what is left to ordinary sums.

    `image` is p of a source displaced by p * period along the tube, from -images to images; `node`
    the number of the cell's grid point nearest to the target. Entries that are not `valid` are
    padding. `count` is the number of all close pairs that were found: not all are listed if
    `overflow` is true. `left_out` has the close pairs, listed or not.
    """

    image: Int[Array, " pair"]
    group: Int[Array, " pair"]
    target: Int[Array, " pair"]
    cell: Int[Array, " pair"]
    node: Int[Array, " pair"]
    valid: Bool[Array, " pair"]
    count: Int[Array, ""]
    overflow: Bool[Array, ""]
    left_out: LeftOut

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
    targets, sources, period = jax.lax.stop_gradient((targets, sources, jnp.asarray(period)))
    chunks = chunks_of(targets, owners, period=period, images=images)
    cells = jnp.arange(sources.shape[0])
    # So that a target that is no number takes nothing from the others of its chunk.
    within = ~(chunks.distance(sources) >= distance) & ~chunks.own(cells)
    size = min(within.size, max(PAIR_CHUNK, ROWS_PER_CHUNK * chunks.points.shape[0]))
    pairs = jnp.nonzero(within.ravel(), size=size, fill_value=0)[0]
    reached = jnp.sum(within)
    listed = jnp.minimum(reached, size)
    square = _least_squares(chunks, sources, pairs, listed)
    close = square < distance**2
    image, chunk, cell = jnp.unravel_index(pairs, within.shape)
    close = close & ~chunks.filling[chunk]
    count = jnp.sum(close)
    row, place = jnp.divmod(jnp.nonzero(close.ravel(), size=capacity, fill_value=0)[0], CHUNK)
    group, before = jnp.divmod(chunk[row], chunks.by_group)
    target, valid = before * CHUNK + place, jnp.arange(capacity) < count
    shift = jnp.array([0.0, 0.0, 1.0]) * ((image[row] - images) * period)[:, None]
    shifted = targets[group, target] - shift
    # What is beyond the list's end has no place among the rows.
    places = jnp.where(jnp.arange(size) < listed, pairs, within.size)
    rows = jnp.full(within.size, -1).at[places].set(jnp.arange(size), mode="drop")
    return ClosePairs(
        image=image[row] - images,
        group=group,
        target=target,
        cell=cell[row],
        node=_nearest_nodes(shifted, cell[row], sources, jnp.minimum(count, capacity)),
        valid=valid,
        count=count,
        overflow=(count > capacity) | (reached > size),
        left_out=LeftOut(rows.reshape(within.shape), close),
    )


def _least_squares(
    chunks: Chunks,
    sources: Float[Array, "cell source 3"],
    pairs: Int[Array, " row"],
    listed: Int[Array, ""],
) -> Float[Array, "row target"]:
    """Squared distances to the nearest grid point, of the first `listed` pairs.

    `pairs` are flat numbers of an image, a chunk and a cell; infinite beyond those listed.
    """
    moved = chunks.moved
    shape = (*moved.shape[:2], sources.shape[0])

    def least(pair: Int[Array, ""]) -> Float[Array, " target"]:
        image, chunk, cell = jnp.unravel_index(pair, shape)
        d = [moved[image, chunk, :, None, i] - sources[cell, :, i] for i in range(3)]
        return jnp.min(d[0] ** 2 + d[1] ** 2 + d[2] ** 2, axis=1)

    def fill(number: Array, found: Array) -> Array:
        # What is beyond the last pair repeats it.
        row = jnp.minimum(ROWS_AT_ONCE * number + jnp.arange(ROWS_AT_ONCE), listed - 1)
        return found.at[row].set(jax.vmap(least)(pairs[row]))

    start = jnp.full((pairs.size, CHUNK), jnp.inf)
    return jax.lax.fori_loop(0, -(-listed // ROWS_AT_ONCE), fill, start)


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
