"""Sums of the near kernel over the nodes of a polar rule about each target; their derivatives."""

from functools import partial

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from celltrain.compiled import NODE_FORCES
from celltrain.flow.ewald import near_scalars


@partial(jax.custom_jvp, nondiff_argnums=(0,))
def force_sums(
    parameter: float,
    targets: Float[Array, "*target 3"],
    nodes: Float[Array, "6 *target radial azimuthal"],
    weights: Float[Array, "radial azimuthal"],
) -> Float[Array, "*target 3"]:
    """sum_s w_s G_near(x - y_s) f_s, by a compiled loop; derivatives are those of the formula."""
    shape = jax.ShapeDtypeStruct(targets.shape, float)
    call = jax.ffi.ffi_call(NODE_FORCES, shape, vmap_method="sequential")
    return call(targets, nodes, weights, jnp.asarray(parameter))


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
    isotropic, dyadic = near_scalars(d[0] ** 2 + d[1] ** 2 + d[2] ** 2, parameter)
    along = dyadic * (d[0] * force[0] + d[1] * force[1] + d[2] * force[2])
    parts = [jnp.sum(isotropic * force[i] + d[i] * along, axis=(-2, -1)) for i in range(3)]
    return jnp.stack(parts, axis=-1)
