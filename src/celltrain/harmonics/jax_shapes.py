"""Shapes as arrays of JAX: one, and those of several cells, in r0."""

from jaxtyping import Array, Float

import celltrain.runtime  # noqa: F401

JaxShape = Float[Array, "3 coefficient"]
JaxShapes = Float[Array, "cell 3 coefficient"]
