"""The far part of the flow through the nonuniform transforms, beside the sum over wave vectors."""

from collections.abc import Callable
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array

from celltrain.flow import PeriodicTube, Sources, periodic_tube
from celltrain.flow.ewald import far_velocity_modes

RADIUS, PERIOD, COUNT = 2.0, 5.0, 40


def points(seed: int) -> Array:
    """Points [cell, ring, azimuth, 3] in a tube, some of them on its axis and in other periods."""
    draw = np.random.default_rng(seed)
    found = draw.uniform(-1.3, 1.3, (2, 4, COUNT // 8, 3))
    found[..., 2] *= 3.0
    found[0, 0, :, :2] = 0.0
    return jnp.asarray(found)


def far_flow(tube: PeriodicTube, targets: Array, sources: Sources) -> Array:
    """By the transforms."""
    return tube.transform.synthesise(targets.reshape(-1, 3), tube._far_modes(sources))


def summed_flow(tube: PeriodicTube, targets: Array, sources: Sources) -> Array:
    """By terms, with the modes of negative kz as conjugates of the others."""
    kx, ky, kz = tube.transform.wave_vectors()

    def phases(places: Array) -> Array:
        x, y, z = (places.reshape(-1, 3)[:, i, None, None, None] for i in range(3))
        return jnp.exp(1j * (kx * x + ky * y + kz * z))

    def modes(strengths: Array | None) -> tuple[Array, ...] | None:
        if strengths is None:
            return None
        given = strengths.reshape(COUNT, -1)
        return tuple(jnp.einsum("sp,sxyz->pxyz", given, jnp.conj(phases(sources.points))))

    velocity = far_velocity_modes(
        modes(sources.forces),
        modes(sources.stresslets),
        (kx, ky, kz),
        jnp.prod(tube.transform.box),
        tube.near_parameter,
    )
    twice = jnp.where(kz > 0.0, 2.0, 1.0)
    return jnp.einsum("ixyz,sxyz->si", twice * jnp.stack(velocity), phases(targets)).real


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-9])
@pytest.mark.parametrize("kind", ["forces", "stresslets"])
def test_it_is_the_sum_over_wave_vectors(kind: str, tolerance: float) -> None:
    """To the tolerance, and its derivatives to twice as much, relative to the largest."""
    tube = periodic_tube(
        2.0 * RADIUS, PERIOD, wall_gap=1.0, extent=2.0, cutoff=2.0, tolerance=tolerance
    )
    draw = np.random.default_rng(3)
    strengths = jnp.asarray(draw.normal(size=(2, 4, COUNT // 8, 3 if kind == "forces" else 6)))
    moved = [jnp.asarray(draw.normal(size=points(1).shape)) for _ in range(2)]

    def flow(way: Callable[..., Array], targets: Array, places: Array) -> Array:
        return way(tube, targets, Sources(places, **{kind: strengths}))

    given = (points(1), points(2))
    by_transforms = jax.jvp(partial(flow, far_flow), given, tuple(moved))
    by_terms = jax.jvp(partial(flow, summed_flow), given, tuple(moved))
    for found, expected, most in zip(by_transforms, by_terms, (1.0, 2.0), strict=True):
        error = np.abs(found - expected).max() / np.abs(expected).max()
        assert error < most * tolerance
