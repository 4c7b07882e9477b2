"""Sums of the near kernel over pairs of targets and source points, in bounded memory.

Targets come in groups, sources in blocks (one per cell). The sum runs over chunks of targets and,
for each, over the blocks and their axial images; blocks out of the kernel's range are skipped, so
the cost follows the number of close pairs and no array holds more than one chunk times one block.

The derivative is given in closed form: with D_k G the derivative of the kernel,

    d sum_s G(x - y_s) f_s = sum_s G df_s - sum_s (D_k G f_s) (dy_sk - dx_k),

two dense matrices per chunk and block, so that many directions at once are matrix products.
"""

from functools import partial

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from celltrain.flow.ewald import near_scalars, near_slopes

CHUNK = 64


def _differences(
    targets: Float[Array, "target 3"], sources: Float[Array, "source 3"]
) -> tuple[list[Array], Array]:
    parts = [targets[:, None, i] - sources[None, :, i] for i in range(3)]
    return parts, parts[0] ** 2 + parts[1] ** 2 + parts[2] ** 2


@partial(jax.custom_jvp, nondiff_argnums=(3,))
def block_sum(
    targets: Float[Array, "target 3"],
    sources: Float[Array, "source 3"],
    strengths: Float[Array, "source 3"],
    parameter: float,
) -> Float[Array, "target 3"]:
    """sum_s G_near(x - y_s) f_s for one chunk of targets and one block of sources."""
    d, square = _differences(targets, sources)
    isotropic, dyadic = near_scalars(square, parameter)
    scaled = dyadic * (d[0] * strengths[:, 0] + d[1] * strengths[:, 1] + d[2] * strengths[:, 2])
    # sum_s d_i w_s = x_i sum_s w_s - sum_s w_s y_si: products instead of elementwise sums.
    moment = scaled @ jnp.concatenate([sources, jnp.ones_like(sources[:, :1])], axis=1)
    return isotropic @ strengths + targets * moment[:, 3:] - moment[:, :3]


@block_sum.defjvp
def _block_sum_jvp(parameter, primals, tangents):  # type: ignore[no-untyped-def]
    targets, sources, strengths = primals
    d_targets, d_sources, d_strengths = tangents
    d, square = _differences(targets, sources)
    isotropic, dyadic = near_scalars(square, parameter)
    isotropic_slope, dyadic_slope = near_slopes(square, parameter)
    along = d[0] * strengths[:, 0] + d[1] * strengths[:, 1] + d[2] * strengths[:, 2]
    zero = jnp.zeros_like(square)
    kernel = jnp.stack(
        [
            jnp.stack([dyadic * d[i] * d[j] + (isotropic if i == j else zero) for j in range(3)])
            for i in range(3)
        ]
    )
    slope = jnp.stack(
        [
            jnp.stack(
                [
                    isotropic_slope * d[k] * strengths[:, i]
                    + dyadic_slope * along * d[i] * d[k]
                    + dyadic * (d[i] * strengths[:, k] + (along if i == k else zero))
                    for k in range(3)
                ]
            )
            for i in range(3)
        ]
    )
    value = jnp.einsum("ijts,sj->ti", kernel, strengths)
    moved = jnp.einsum("ijts,sj->ti", kernel, d_strengths)
    moved -= jnp.einsum("ikts,sk->ti", slope, d_sources)
    moved += jnp.einsum("ikt,tk->ti", jnp.sum(slope, axis=-1), d_targets)
    return value, moved


def near_sum(
    targets: Float[Array, "group target 3"],
    owners: Int[Array, " group"],
    sources: Float[Array, "cell source 3"],
    strengths: Float[Array, "cell source 3"],
    *,
    parameter: float,
    cutoff: float,
    period: Float[Array, ""],
    images: int,
) -> Float[Array, "image group target 3"]:
    """Near sums of every axial image p = -images .. images of the sources, one by one.

    **Arguments:** `owners`: the cell on whose surface a group of targets lies, -1 for none; the
    block of a group's own cell is left out (its integral is singular). Image p of a source is
    displaced by p * `period` along the tube.
    """
    groups, count, _ = targets.shape
    chunks = -(-count // CHUNK)
    padding = chunks * CHUNK - count
    # Padding repeats the last target of the group: harmless for the chunk's axial extent.
    padded = jnp.pad(targets, ((0, 0), (0, padding), (0, 0)), mode="edge")
    padded = padded.reshape(groups * chunks, CHUNK, 3)
    chunk_owners = jnp.repeat(owners, chunks)
    shifts = jnp.arange(-images, images + 1)
    low, high = jnp.min(sources[..., 2], axis=1), jnp.max(sources[..., 2], axis=1)
    cells = jnp.arange(sources.shape[0])

    def of_chunk(chunk: tuple[Array, Array]) -> Float[Array, "image target 3"]:
        points, owner = chunk
        bottom, top = jnp.min(points[:, 2]), jnp.max(points[:, 2])

        def of_image(shift: Int[Array, ""]) -> Float[Array, "target 3"]:
            offset = shift * period

            def add(total: Array, cell: Array) -> tuple[Array, None]:
                in_range = (low[cell] + offset - top < cutoff) & (
                    bottom - high[cell] - offset < cutoff
                )
                is_own = (owner == cell) & (shift == 0)

                def with_block(total: Array) -> Array:
                    moved = points - jnp.array([0.0, 0.0, 1.0]) * offset
                    return total + block_sum(moved, sources[cell], strengths[cell], parameter)

                return jax.lax.cond(in_range & ~is_own, with_block, lambda t: t, total), None

            return jax.lax.scan(add, jnp.zeros_like(points), cells)[0]

        return jax.lax.map(of_image, shifts)

    summed = jax.lax.map(of_chunk, (padded, chunk_owners))
    summed = jnp.moveaxis(summed, 1, 0).reshape(2 * images + 1, groups, chunks * CHUNK, 3)
    return summed[:, :, :count]
