"""The settings of JAX, and what depends on its platforms, for every module that uses it.

* 64-bit floats. They must be switched on before the first array exists.
* The persistent compilation cache, so that the second run of a command does not compile again. Its
  folder is `$XDG_CACHE_HOME/celltrain` or `~/.cache/celltrain`, unless the user has given JAX one;
  that and its other settings are then left alone. Where JAX was loaded before this package it has
  none, because XLA would write lines of warnings for each program that it holds.
* What JAX compiles is reported to the clock (see `clock`).

What must be said before JAX is loaded is in `environment`.
"""

from functools import cache
from typing import Any

import jax
import numpy as np
from jax.extend import backend
from jaxtyping import Array
from numpy.typing import ArrayLike

from celltrain.clock import compilation
from celltrain.environment import JAX_CAME_FIRST, PROGRAMS, UnsuitableSetting


def setting(name: str) -> Any:
    """A setting of JAX."""
    return getattr(jax.config, name)  # of which its types do not know


def _configure() -> None:
    jax.config.update("jax_enable_x64", True)
    if setting("jax_compilation_cache_dir") is None and PROGRAMS and not JAX_CAME_FIRST:
        jax.config.update("jax_compilation_cache_dir", PROGRAMS)
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    jax.monitoring.register_event_duration_secs_listener(compilation.listen)


def check_jax() -> None:
    """Refuse settings of JAX with which nothing can be computed.

    Raises:
        UnsuitableSetting: if it cannot as it is set, with what to do.
    """
    if not setting("jax_enable_x64"):
        raise UnsuitableSetting(
            "JAX was set to 32-bit floats after celltrain had set it to 64-bit ones; allowed:"
            " jax.config.update('jax_enable_x64', True)"
        )
    promotion = setting("jax_numpy_dtype_promotion")
    if promotion != "standard":
        raise UnsuitableSetting(
            f"jax_numpy_dtype_promotion = {promotion!r} is not allowed;"
            " allowed: jax.config.update('jax_numpy_dtype_promotion', 'standard')"
        )
    try:
        jax.devices()
    except RuntimeError as error:
        platforms = setting("jax_platforms")
        raise UnsuitableSetting(
            f"JAX_PLATFORMS = {platforms!r} is not allowed here ({str(error).splitlines()[0]});"
            " allowed: cpu, or none given"
        ) from None


@cache
def only_processors() -> bool:
    """Whether JAX finds no other platform here than the CPU."""
    return set(backend.backends()) == {"cpu"}


def constant(values: ArrayLike) -> Array:
    """Floats or integers as an array of JAX; `values` must not be changed afterwards.

    `jnp.asarray` compiles a program for every shape, which takes longer than making the tables.
    """
    return jax.device_put(np.asarray(values))


_configure()
