"""Motion and strain energy of disturbances of a whole train."""

from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain.diagnostics import (
    disturbance_amplitude,
    energy_parts,
    frame,
    mode_motion,
    perturbation_energy,
)
from celltrain.harmonics import UNIT_DISPLACEMENT, azimuthal_basis
from celltrain.membrane import place_cells
from celltrain.membrane.energy import Membrane
from celltrain.parameters import CaseError
from celltrain.stability import Mode, Stability, TransientMode
from celltrain.steady import Base
from celltrain.train import train_membrane


def waves(
    result: Stability, mode: Mode | TransientMode, vector: np.ndarray, phase: float
) -> np.ndarray:
    """Re(vector exp(i (q p + phase))) for every cell p."""
    base = result.base
    basis = azimuthal_basis(base.train.degree, mode.azimuthal_number)
    q = 2 * np.pi * mode.wave_number / base.train.cells
    turn = np.exp(1j * (q * np.arange(base.train.cells) + phase))
    return np.einsum("p,u,uik->pik", turn, vector, basis).real


@pytest.mark.parametrize(("m", "wave"), [(1, 0), (1, 1), (2, 1), (0, 2)])
def test_motion_of_a_mode_is_that_of_a_small_finite_disturbance(
    m: int, wave: int, make_stability: Callable[..., Stability]
) -> None:
    result = make_stability()
    base = result.base
    mode = next(
        each for each in result.modes if (each.azimuthal_number, each.wave_number) == (m, wave)
    )
    vector = result.right_vectors[m][wave, :, mode.index]
    found = mode_motion(result, mode)
    size = 1e-6
    squares = np.zeros(3)
    # Two phases a quarter apart are the mean over all.
    for phase in (0.3, 0.3 + np.pi / 2):
        disturbance = waves(result, mode, vector, phase)
        rates = waves(result, mode, result.blocks[m][wave] @ vector, phase)
        shapes = place_cells(base.coefficients, base.train, base.train.cells) + size * disturbance
        measured = frame(base.train, shapes, size * rates)
        squares += [
            np.mean((measured["tumbling"] / size) ** 2),
            np.mean((measured["tank_treading"] / size) ** 2),
            disturbance_amplitude(disturbance) ** 2 / base.train.cells,
        ]
    tumbling, tank_treading, norm = np.sqrt(squares)
    assert (max(tumbling, tank_treading) / norm > 1e-3) == (m < 2)
    assert_allclose(found.tumbling, tumbling / norm, rtol=1e-4, atol=1e-6)
    assert_allclose(found.tank_treading, tank_treading / norm, rtol=1e-4, atol=1e-6)


def test_a_tilting_mode_tumbles_at_its_growth_rate(
    make_stability: Callable[..., Stability],
) -> None:
    """A mode that is a rigid turn about the centroid: omega is its growth rate times the tilt."""
    result = make_stability()
    base = result.base
    basis = azimuthal_basis(6, 1)
    shapes = place_cells(base.coefficients, base.train, base.train.cells)
    centre = frame(base.train, shapes, 0 * shapes)["centroid"][0]
    about = np.array([0.0, -1.0, 0.0])
    shape = base.coefficients.copy()
    shape[:, 0] -= UNIT_DISPLACEMENT * centre
    tilt = np.cross(about, shape, axisb=0, axisc=0)
    vector = np.einsum("uik,ik->u", basis, tilt)
    assert_allclose(np.tensordot(vector, basis, axes=1), tilt, atol=1e-12)
    rate = 0.37
    result.blocks[1][1] = rate * np.eye(len(basis))
    found = mode_motion(result, TransientMode(rate, 1, 1, vector.astype(complex)))
    assert_allclose(found.tumbling, rate / disturbance_amplitude(tilt[None]), rtol=1e-9)
    assert found.tank_treading < 1e-9 * found.tumbling


@pytest.fixture
def tilted(make_stability: Callable[..., Stability]) -> tuple[Base, np.ndarray]:
    result = make_stability()
    return result.base, waves(result, result.leading, result.right_vectors[1][0, :, 0], 0.0)


@eqx.filter_jit
def second_variation(cell: Membrane, shape: jax.Array, step: jax.Array) -> jax.Array:
    def along(size: jax.Array) -> jax.Array:
        return energy_parts(cell, shape + size * step)

    slope = jax.jacfwd(along)
    return jnp.stack([slope(0.0), jax.jacfwd(slope)(0.0)])


def test_energy_of_a_disturbance_is_its_second_variation(tilted: tuple[Base, np.ndarray]) -> None:
    base, disturbance = tilted
    found = perturbation_energy(base, disturbance, 1e-4)
    step = disturbance[0] / disturbance_amplitude(disturbance)
    first, second = second_variation(
        train_membrane(base.train), jnp.asarray(base.coefficients), jnp.asarray(step)
    )
    assert_allclose(first, 0.0, atol=1e-12)
    assert_allclose(found, 0.5e-4 * second, rtol=1e-5)
    assert_allclose(perturbation_energy(base, -7.0 * disturbance, 1e-4), found, rtol=1e-5)
    assert_allclose(perturbation_energy(base, disturbance, 2e-4), 2 * found, rtol=1e-5)


def test_energy_of_a_uniform_axisymmetric_disturbance_has_a_sign(
    make_base: Callable[..., Base],
) -> None:
    base = make_base()
    longer = np.zeros((4, *base.coefficients.shape))
    longer[:, 2] = base.coefficients[2]
    there, back = (perturbation_energy(base, sign * longer, 1e-5) for sign in (1, -1))
    assert_allclose(there, -back, rtol=1e-2)
    assert np.abs(there).min() > 1e-3


def test_energy_of_nothing_is_refused(tilted: tuple[Base, np.ndarray]) -> None:
    base, disturbance = tilted
    with pytest.raises(CaseError, match="allowed are both > 0"):
        perturbation_energy(base, 0.0 * disturbance)
    with pytest.raises(CaseError, match="amplitude = -1"):
        perturbation_energy(base, disturbance, -1.0)
