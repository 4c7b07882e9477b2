"""The linear part of exponential steps: functions of matrices, derivatives, cells that turn."""

import numpy as np
import pytest
import scipy.linalg
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from celltrain.evolution import Repulsion
from celltrain.evolution.dynamics import Dynamics, train_dynamics
from celltrain.evolution.linear_part import LinearPart, _functions, level_of, step_of
from celltrain.harmonics import displaced
from celltrain.steady import Base


@pytest.fixture(scope="module")
def dynamics(coarse_base: Base) -> Dynamics:
    return train_dynamics(coarse_base, Repulsion(), wall_gap=0.8)


@pytest.fixture(scope="module")
def linear(dynamics: Dynamics) -> LinearPart:
    assert dynamics.linear_part is not None
    return dynamics.linear_part


@pytest.mark.parametrize("size", [1e-3, 0.4, 30.0, 3000.0])
def test_functions_of_matrices(size: float) -> None:
    random = np.random.default_rng(4)
    part = random.normal(size=(2, 6, 6)) + 1j * random.normal(size=(2, 6, 6))
    # Decaying, as a stiff membrane, and with a direction in which nothing happens.
    z = -size * part @ part.conj().transpose(0, 2, 1) / 36.0
    z[:, :, 0] = 0.0
    for each, *functions in zip(z, *_functions(z), strict=True):
        augmented = np.zeros((24, 24), complex)
        augmented[:6, :6] = each
        augmented[:18, 6:] = np.eye(18)
        exact = scipy.linalg.expm(augmented)[:6]
        for number, function in enumerate(functions, 1):
            assert_allclose(function, exact[:, 6 * number : 6 * number + 6], atol=1e-12)


def test_steps_are_powers_of_the_root_of_two() -> None:
    assert [step_of(level) for level in (-4, 0, 2, 6)] == [0.25, 1.0, 2.0, 8.0]
    for level in range(-30, 10):
        assert level_of(step_of(level)) == level
        assert level_of(1.4 * step_of(level)) == level


def test_the_linear_part_is_the_derivative_of_the_rates(
    dynamics: Dynamics, linear: LinearPart
) -> None:
    base = np.asarray(dynamics.base)
    change = np.zeros_like(base)
    # All wave numbers, azimuthal numbers 0 to 3 in both families.
    change[:, :, :9] = np.random.default_rng(1).normal(size=(3, 3, 9))
    step = 1e-4
    difference = (dynamics.rates(base + step * change) - dynamics.rates(base - step * change)) / (
        2.0 * step
    )
    turns = linear.turns(base)
    assert_allclose(turns, np.broadcast_to(np.eye(3), (3, 3, 3)), atol=1e-12)
    found = linear.applied(turns, change)
    assert np.abs(difference - found).max() < 2e-3 * np.abs(found).max()


def test_the_linear_part_turns_with_the_cells(dynamics: Dynamics, linear: LinearPart) -> None:
    base = np.asarray(dynamics.base)
    rotations = Rotation.random(3, random_state=5).as_matrix()
    turned = displaced(np.einsum("cij,cjk->cik", rotations, base), np.ones((3, 3)))
    turns = linear.turns(turned)
    assert_allclose(turns, rotations, atol=1e-12)
    change = np.random.default_rng(2).normal(size=base.shape)
    still = linear.turns(base)
    level = -3
    for function in (
        linear.applied,
        lambda turns, change: linear.phi_1(level, turns, change),
        lambda turns, change: linear.phi_2(level, turns, change),
        lambda turns, change: linear.phi_3(level, turns, change),
    ):
        moved = function(turns, np.einsum("cij,cjk->cik", rotations, change))
        assert_allclose(
            moved, np.einsum("cij,cjk->cik", rotations, function(still, change)), atol=1e-11
        )
