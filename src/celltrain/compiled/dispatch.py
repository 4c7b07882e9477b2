"""The choice between a compiled loop and the plain formula of the same sum."""

from collections.abc import Callable
from typing import Any

import jax
from jaxtyping import Array, Float

from celltrain.compiled.call_frame import ARGUMENTS, LOOPS_SERVE
from celltrain.compiled.loops import make
from celltrain.runtime import by_platform


def loop(name: str, shape: tuple[int, ...], *arguments: Array) -> Float[Array, "..."]:
    """Result of the compiled loop of a name (see `loops`), an array of the given shape.

    **Raises:** `TypeError` for arguments of other types than the loop's.
    """
    make(name)
    given = tuple(each.dtype for each in arguments)
    if given != ARGUMENTS[name]:
        raise TypeError(f"{name} is given {given} in place of {ARGUMENTS[name]}")
    result = jax.ShapeDtypeStruct(shape, float)
    return jax.ffi.ffi_call(name, result, vmap_method="sequential")(*arguments)


def compiled_or_plain(
    compiled: Callable[..., Array], plain: Callable[..., Array], *arguments: Any
) -> Float[Array, "..."]:
    """What the compiled loops give on processors where they serve, and the formula elsewhere.

    Which of them a program contains is decided when it is compiled for a platform, or before where
    there is only one. Both take the same arguments, arrays or trees of them, and agree to rounding.
    """
    if not LOOPS_SERVE:
        return plain(*arguments)
    return by_platform({"cpu": compiled}, plain, *arguments)
