"""Fields at the wall's points from their modes, beside the plain sum over wave vectors."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain.flow.transform import Transform
from celltrain.flow.wall import tube_wall
from celltrain.flow.wall_synthesis import WallSynthesis, wall_synthesis

RADIUS, PERIOD = 1.7, 5.0


@pytest.mark.parametrize("along", [4, 7, 8, 20])
def test_fields_are_the_sum_over_wave_vectors(along: int) -> None:
    """Of fewer waves than rings, of as many, and of more, of which some are the same there."""
    wall = tube_wall(RADIUS, PERIOD, wall_gap=0.8, tolerance=1e-4)
    assert wall.rings == 15
    transform = Transform((2, 3, along), 1e-4, jnp.array([4.0, 4.5, PERIOD]))
    parts = np.random.default_rng(0).normal(size=(2, 3, 5, 7, along + 1))
    modes = parts[0] + 1j * parts[1]
    points = np.asarray(wall.points())
    kx, ky, kz = np.broadcast_arrays(*map(np.asarray, transform.wave_vectors()))
    waves = np.stack([kx, ky, kz], axis=-1).reshape(-1, 3)
    # Those that are left out are conjugates.
    twice = np.where(kz, 2.0, 1.0)
    expected = (np.exp(1j * points @ waves.T) @ (twice * modes).reshape(3, -1).T).real
    synthesis = wall_synthesis(transform, wall)
    found = jax.jit(WallSynthesis.fields)(synthesis, jnp.asarray(modes))
    assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
