"""Sums of the near kernel over the nodes of a polar rule about each target; their derivatives."""

from functools import partial

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from celltrain.compiled import NODE_FORCES, compiled_or_plain, loop
from celltrain.compiled.kernels import squared, stokeslet
from celltrain.flow.ewald import near_scalars


@partial(jax.custom_jvp, nondiff_argnums=(0,))
def force_sums(
    parameter: float,
    targets: Float[Array, "*target 3"],
    nodes: Float[Array, "6 *target radial azimuthal"],
    weights: Float[Array, "radial azimuthal"],
) -> Float[Array, "*target 3"]:
    """sum_s w_s G_near(x - y_s) f_s, by a compiled loop where there is one.

    Derivatives are those of the formula.
    """

    def compiled(targets: Array, nodes: Array, weights: Array) -> Array:
        return loop(NODE_FORCES, targets.shape, targets, nodes, weights, jnp.asarray(parameter))

    return compiled_or_plain(compiled, partial(_formula, parameter), targets, nodes, weights)


@force_sums.defjvp
def _force_sums_jvp(parameter, primals, tangents):  # type: ignore[no-untyped-def]
    _, moved = jax.jvp(partial(_formula, parameter), primals, tangents)
    return force_sums(parameter, *primals), moved


def _formula(
    parameter: float,
    targets: Float[Array, "*target 3"],
    nodes: Float[Array, "6 *target radial azimuthal"],
    weights: Float[Array, "radial azimuthal"],
) -> Float[Array, "*target 3"]:
    """What `force_sums` computes."""
    d = [targets[..., i, None, None] - nodes[i] for i in range(3)]
    force = nodes[3:] * weights
    parts = stokeslet(near_scalars(squared(d), parameter), d, force)
    return jnp.stack([jnp.sum(part, axis=(-2, -1)) for part in parts], axis=-1)
