"""Sums of the near kernels over pairs of targets and source points, in bounded memory.

Targets come in chunks, sources in blocks of a cell's points. The sum runs over those pairs of a
chunk and an axial image of a block whose bounding boxes are within the kernel's range, so the cost
follows the number of near pairs and no array holds more than one chunk times one block.

The sums themselves are compiled loops where these serve (`compiled.pairs`), which also pass by
the patches of a block that are out of a target's range. The formulas here are what they compute;
they take their place elsewhere, and give their derivatives. That of the force's sum is in closed
form: with D_k G the derivative of the kernel,

    d sum_s G(x - y_s) f_s = sum_s G df_s - sum_s (D_k G f_s) (dy_sk - dx_k),

two dense matrices per chunk and block, so that many directions at once are matrix products.
"""

import math
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from celltrain.compiled import compiled_or_plain, loop
from celltrain.compiled.kernels import UNFOLD, squared, stokeslet_gradient, stokeslet_matrix
from celltrain.compiled.loops import FORCE_PAIRS, STRESSLET_PAIRS, CompiledLoop
from celltrain.flow.ewald import near_scalars, near_slopes, near_stress_scalars
from celltrain.flow.sources import Sources
from celltrain.proximity.chunks import CHUNK, chunks_of
from celltrain.proximity.close_pairs import LeftOut

# Pairs that the formula takes at a time: enough to occupy a graphics processor.
BATCH = 16
# Rings of a grid in a band, along which a block's points follow each other.
BAND = 4
# Such points that loops take or pass by together: whole vectors of any processor.
PATCH = 16


def _differences(
    targets: Float[Array, "target 3"], sources: Float[Array, "source 3"]
) -> tuple[list[Array], Array]:
    parts = [targets[:, None, i] - sources[None, :, i] for i in range(3)]
    return parts, squared(parts)


@partial(jax.custom_jvp, nondiff_argnums=(3, 4))
def block_sum(
    targets: Float[Array, "target 3"],
    sources: Float[Array, "source 3"],
    strengths: Float[Array, "source 3"],
    parameter: float,
    cutoff: float = math.inf,
) -> Float[Array, "target 3"]:
    """sum_s G_near(x - y_s) f_s over |x - y_s| < cutoff, of a chunk of targets and a block."""
    d, square = _differences(targets, sources)
    # Two products use them: without the barrier XLA computes them twice.
    isotropic, dyadic = jax.lax.optimization_barrier(near_scalars(square, parameter, cutoff))
    scaled = dyadic * (d[0] * strengths[:, 0] + d[1] * strengths[:, 1] + d[2] * strengths[:, 2])
    # sum_s d_i w_s = x_i sum_s w_s - sum_s w_s y_si: products instead of elementwise sums.
    moment = scaled @ jnp.concatenate([sources, jnp.ones_like(sources[:, :1])], axis=1)
    return isotropic @ strengths + targets * moment[:, 3:] - moment[:, :3]


@block_sum.defjvp
def _block_sum_jvp(parameter, cutoff, primals, tangents):  # type: ignore[no-untyped-def]
    targets, sources, strengths = primals
    d_targets, d_sources, d_strengths = tangents
    d, square = _differences(targets, sources)
    scalars = near_scalars(square, parameter, cutoff)
    slopes = near_slopes(square, parameter, cutoff)
    matrix = stokeslet_matrix(scalars, d)
    kernel = jnp.stack([jnp.stack([matrix[place] for place in row]) for row in UNFOLD])
    gradient = stokeslet_gradient(scalars, slopes, d, strengths.T)
    slope = jnp.stack([jnp.stack(gradient[3 * i : 3 * i + 3]) for i in range(3)])
    value = jnp.einsum("ijts,sj->ti", kernel, strengths)
    moved = jnp.einsum("ijts,sj->ti", kernel, d_strengths)
    moved -= jnp.einsum("ikts,sk->ti", slope, d_sources)
    moved += jnp.einsum("ikt,tk->ti", jnp.sum(slope, axis=-1), d_targets)
    return value, moved


def stresslet_block_sum(
    targets: Float[Array, "target 3"],
    sources: Float[Array, "source 3"],
    stresslets: Float[Array, "source 6"],
    parameter: float,
    cutoff: float = math.inf,
) -> Float[Array, "target 3"]:
    """sum_s T_near(y_s - x)_ijk D_jk/2 over |x - y_s| < cutoff, of a chunk and a block.

    D = w n + n w are symmetric dyads (xx, xy, xz, yy, yz, zz).
    """
    d, square = _differences(targets, sources)
    linear, cubic = jax.lax.optimization_barrier(near_stress_scalars(square, parameter, cutoff))
    xx, xy, xz, yy, yz, zz = (stresslets[:, i] for i in range(6))
    along = d[0] * (xx * d[0] + 2.0 * (xy * d[1] + xz * d[2]))
    along = along + d[1] * (yy * d[1] + 2.0 * yz * d[2]) + zz * d[2] ** 2
    scaled = 0.5 * (linear * (xx + yy + zz) + cubic * along)
    x, y, z = (sources[:, i] for i in range(3))
    turned = jnp.stack(
        [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z]
    )
    dipole = linear @ jnp.concatenate([stresslets, turned.T], axis=1)
    moment = scaled @ jnp.concatenate([sources, jnp.ones_like(sources[:, :1])], axis=1)
    turned = jnp.einsum("tij,tj->ti", dipole[:, UNFOLD], targets) - dipole[:, 6:]
    # T(y - x) = -T(x - y).
    return moment[:, :3] - targets * moment[:, 3:] - turned


def near_sum(
    targets: Float[Array, "group target 3"],
    owners: Int[Array, " group"],
    sources: Sources,
    *,
    parameter: float,
    cutoff: float,
    period: Float[Array, ""],
    images: int,
    coarse_beyond: float = math.inf,
    left_out: LeftOut | None = None,
) -> Float[Array, "group target 3"]:
    """Near sums over the axial images p = -images .. images of the sources.

    **Arguments:** `owners`: the cell on whose surface a group of targets lies, -1 for none; the
    block of a group's own cell is left out (its integral is singular). Image p of a source is
    displaced by p * `period` along the tube. Sources at the distance `cutoff` or farther give
    nothing. Cells farther from a chunk of targets than `coarse_beyond` contribute with their coarse
    samples, if there are such. `left_out`: pairs to which a cell contributes nothing.
    """
    chunks = chunks_of(targets, owners, period=period, images=images)
    points, forces, dyads = (
        _in_blocks(sources, name) for name in ("points", "forces", "stresslets")
    )
    assert points is not None
    cells = jnp.tile(jnp.arange(sources.cells), points.shape[0] // sources.cells)
    # So that a target that is no number takes nothing from the others of its chunk.
    near = ~(chunks.distance(points) >= cutoff)
    if sources.coarse is not None:
        far = chunks.distance(sources.points.reshape(sources.cells, -1, 3)) >= coarse_beyond
        is_coarse = jnp.arange(cells.size) >= cells.size - sources.cells
        near = near & (far[:, :, cells] == is_coarse)
    pairs = NearPairs(near & ~chunks.own(cells), cells, left_out)
    inputs = (chunks.points, points, forces, dyads, chunks.period)
    summed = pair_sums(parameter, cutoff, *inputs, pairs)
    return chunks.in_groups(jnp.sum(summed, axis=0))


class NearPairs(eqx.Module):
    """Which chunks of targets and images of blocks of sources are near; the blocks' cells."""

    near: Bool[Array, "image chunk block"]
    cells: Int[Array, " block"]
    left_out: LeftOut | None = None


@partial(jax.custom_jvp, nondiff_argnums=(0, 1))
def pair_sums(
    parameter: float,
    cutoff: float,
    targets: Float[Array, "chunk target 3"],
    points: Float[Array, "block source 3"],
    forces: Float[Array, "block source 3"] | None,
    stresslets: Float[Array, "block source 6"] | None,
    period: Float[Array, ""],
    pairs: NearPairs,
) -> Float[Array, "image chunk target 3"]:
    """Sums over the sources within the cutoff in near pairs, by compiled loops where they serve.

    Derivatives are those of the formulas.
    """
    total = jnp.zeros((pairs.near.shape[0], *targets.shape))
    plain = partial(_pair_sums_formula, parameter, cutoff)
    for over, strengths in ((FORCE_PAIRS, (forces, None)), (STRESSLET_PAIRS, (None, stresslets))):
        if any(each is not None for each in strengths):
            compiled = partial(_pair_sums_loop, over, parameter, cutoff)
            given = (pairs, targets, points, *strengths, period)
            total = total + compiled_or_plain(compiled, plain, *given)
    return total


def _pair_sums_loop(
    over: CompiledLoop,
    parameter: float,
    cutoff: float,
    pairs: NearPairs,
    targets: Array,
    points: Array,
    forces: Array | None,
    stresslets: Array | None,
    period: Array,
) -> Array:
    """The sums for one kind of sources, by its compiled loop."""
    shape = (pairs.near.shape[0], *targets.shape)
    left_out = pairs.left_out
    if left_out is None:
        left_out = LeftOut(jnp.zeros((0, 0, 0), dtype=int), jnp.zeros((0, CHUNK), dtype=bool))
    strengths = forces if stresslets is None else stresslets
    assert strengths is not None
    by_patch = _in_patches(points, mode="edge"), _in_patches(strengths, mode="constant")
    places = (pairs.near, pairs.cells, left_out.rows, left_out.close)
    ranges = (_ranges(by_patch[0], cutoff), jnp.stack([parameter, period, cutoff]))
    return loop(over, shape, targets, *by_patch, *places, *ranges)


def _in_patches(
    samples: Float[Array, "block source part"], mode: str
) -> Float[Array, "block patch part place"]:
    """Samples a patch of neighbours at a time; the last one is filled up."""
    blocks, count, parts = samples.shape
    padded = jnp.pad(samples, ((0, 0), (0, -count % PATCH), (0, 0)), mode=mode)
    return jnp.swapaxes(padded.reshape(blocks, -1, PATCH, parts), 2, 3)


def _ranges(
    points: Float[Array, "block patch 3 place"], cutoff: float
) -> Float[Array, "block patch 4"]:
    """Middle and squared radius of balls outside which no source of a patch is in range."""
    middle = 0.5 * (jnp.min(points, axis=3) + jnp.max(points, axis=3))
    square = jnp.max(jnp.sum((points - middle[..., None]) ** 2, axis=2), axis=2)
    return jnp.concatenate([middle, ((jnp.sqrt(square) + cutoff) ** 2)[..., None]], axis=2)


@pair_sums.defjvp
def _pair_sums_jvp(parameter, cutoff, primals, tangents):  # type: ignore[no-untyped-def]
    *inputs, pairs = primals
    formula = partial(_pair_sums_formula, parameter, cutoff, pairs)
    _, moved = jax.jvp(formula, tuple(inputs), tuple(tangents[:-1]))
    return pair_sums(parameter, cutoff, *inputs, pairs), moved


def _pair_sums_formula(
    parameter: float,
    cutoff: float,
    pairs: NearPairs,
    targets: Array,
    points: Array,
    forces: Array | None,
    stresslets: Array | None,
    period: Array,
) -> Array:
    """What `pair_sums` computes, a batch of pairs of a chunk and a block at a time."""
    near, left_out = pairs.near, pairs.left_out
    along = jnp.array([0.0, 0.0, 1.0]) * period
    listed = jnp.nonzero(near.ravel(), size=near.size, fill_value=0)[0]
    count = jnp.sum(near)

    def of_pair(pair: Array, wanted: Array) -> Array:
        image, chunk, block = jnp.unravel_index(pair, near.shape)
        here = targets[chunk] - (image - near.shape[0] // 2) * along
        here, block_points = jax.lax.optimization_barrier((here, points[block]))
        part = jnp.zeros_like(here)
        if forces is not None:
            part = part + block_sum(here, block_points, forces[block], parameter, cutoff)
        if stresslets is not None:
            part = part + stresslet_block_sum(
                here, block_points, stresslets[block], parameter, cutoff
            )
        if left_out is not None:
            row = left_out.rows[image, chunk, pairs.cells[block]]
            wanted = wanted & ~(left_out.close[row] & (row >= 0))[:, None]
        return jnp.where(wanted, part, 0.0)

    def add(number: Array, total: Array) -> Array:
        places = number * BATCH + jnp.arange(BATCH)
        batch = listed[jnp.minimum(places, listed.size - 1)]
        parts = jax.vmap(of_pair)(batch, places < count)
        image, chunk, _ = jnp.unravel_index(batch, near.shape)
        return total.at[image, chunk].add(parts)

    start = jnp.zeros((near.shape[0], *targets.shape))
    return jax.lax.fori_loop(0, -(-count // BATCH), add, start)


def _in_blocks(sources: Sources, name: str) -> Float[Array, "block source part"] | None:
    """Samples in blocks, each of all cells: the quarters of their grids, then the coarse grids.

    A quarter has as many points as the coarse grid: one program serves both.
    """
    samples = getattr(sources, name)
    if samples is None:
        return None
    if sources.coarse is None:
        return _in_bands(samples)
    cells, rings, azimuths, parts = samples.shape
    halves = samples.reshape(cells, 2, rings // 2, 2, azimuths // 2, parts)
    quarters = jnp.transpose(halves, (1, 3, 0, 2, 4, 5)).reshape(
        -1, rings // 2, azimuths // 2, parts
    )
    return _in_bands(jnp.concatenate([quarters, getattr(sources.coarse, name)]))


def _in_bands(samples: Float[Array, "set ring azimuth part"]) -> Float[Array, "set source part"]:
    """Samples of some rings at a time, so that neighbours follow each other."""
    sets, rings, _, parts = samples.shape
    bands = [samples[:, first : first + BAND] for first in range(0, rings, BAND)]
    # Forth and back.
    ways = [band[:, :, :: (-1) ** number] for number, band in enumerate(bands)]
    turned = [jnp.swapaxes(band, 1, 2).reshape(sets, -1, parts) for band in ways]
    return jnp.concatenate(turned, axis=1)
