"""The choice between a compiled loop and the plain formula of the same sum."""

from collections.abc import Callable
from typing import Any

import jax
from jaxtyping import Array, Float

from celltrain.compiled.call_frame import LOOPS_SERVE
from celltrain.compiled.loops import CompiledLoop
from celltrain.programs import call
from celltrain.runtime import only_processors


def loop(compiled: CompiledLoop, shape: tuple[int, ...], *arguments: Array) -> Float[Array, "..."]:
    """Result of a compiled loop, an array of the given shape.

    **Raises:** `TypeError` for arguments of other types than the loop's.
    """
    compiled.check(arguments)
    call(compiled)
    result = jax.ShapeDtypeStruct(shape, float)
    return jax.ffi.ffi_call(compiled.name, result, vmap_method="sequential")(*arguments)


def compiled_or_plain(
    compiled: Callable[..., Array], plain: Callable[..., Array], *arguments: Any
) -> Float[Array, "..."]:
    """What the compiled loops give on processors where they serve, and the formula elsewhere.

    Which of them a program contains is decided when it is compiled for a platform, or before where
    there is only one. Both take the same arguments, arrays or trees of them, and agree to rounding.
    """
    if not LOOPS_SERVE:
        return plain(*arguments)
    if only_processors():
        # Nothing else is traced, which takes half of the time of tracing a simulation.
        return compiled(*arguments)
    found: Array = jax.lax.platform_dependent(*arguments, cpu=compiled, default=plain)
    return found
