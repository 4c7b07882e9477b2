"""The wall's response to waves much longer than the tube is wide."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain.flow.wall import _axial_response, _uniform_response

RADIUS = 3.0
NODES = np.array([0.1, 0.9, 1.7, 2.4, 2.95])


@pytest.mark.parametrize("m", [1, 2, 3, 20])
def test_long_waves_do_what_uniform_flow_does(m: int) -> None:
    uniform = _uniform_response(m, RADIUS, NODES)
    waves = np.array([1e-3, 1e-5, 1e-8])
    for k, found in zip(waves, _axial_response(m, waves, RADIUS, NODES), strict=True):
        # They differ in first order of k R.
        assert_allclose(found, uniform, rtol=0, atol=1.0 * k * RADIUS + 1e-12)


@pytest.mark.parametrize("k", [1e-4, 1e-6, 1e-9])
def test_a_long_wave_through_the_wall_drives_poiseuille_flow(k: float) -> None:
    # The flux 2 pi R u_r through the wall is that which changes along the tube.
    (found,) = _axial_response(0, np.array([k]), RADIUS, NODES)
    profile = 4.0 / (k * RADIUS) * (1.0 - (NODES / RADIUS) ** 2)
    assert_allclose(found[2, 0], profile, rtol=1e-6)
    assert_allclose(found[1, 1], NODES / RADIUS, rtol=1e-6)
    assert_allclose(found[2, 2], 2.0 * (NODES / RADIUS) ** 2 - 1.0, rtol=0, atol=1e-6)
