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


@pytest.mark.parametrize("along", [9, 15, 17, 41])
def test_fields_are_the_sum_over_wave_vectors(along: int) -> None:
    """Of fewer waves than rings, of as many, and of more, of which some are the same there."""
    wall = tube_wall(RADIUS, PERIOD, wall_gap=0.8, tolerance=1e-4)
    assert wall.rings == 15
    transform = Transform((5, 7, along), 1e-4, jnp.array([4.0, 4.5, PERIOD]))
    random = np.random.default_rng(0)
    modes = random.normal(size=(2, 3, *transform.shape))
    modes = modes[0] + 1j * modes[1]
    # Of real fields.
    modes += np.conj(modes[:, ::-1, ::-1, ::-1])
    points = np.asarray(wall.points())
    kx, ky, kz = np.broadcast_arrays(*map(np.asarray, transform.wave_vectors()))
    waves = np.stack([kx, ky, kz], axis=-1).reshape(-1, 3)
    expected = np.exp(1j * points @ waves.T) @ modes.reshape(3, -1).T
    assert np.abs(expected.imag).max() < 1e-11 < np.abs(expected.real).max()
    synthesis = wall_synthesis(transform, wall)
    found = jax.jit(WallSynthesis.fields)(synthesis, jnp.asarray(modes))
    assert_allclose(found, expected.real, rtol=0, atol=1e-12 * np.abs(expected).max())
