"""The kernels' arithmetic: matrices, gradients and both forms of the double layer agree."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain.compiled.kernels import (
    UNFOLD,
    dot,
    free_stresslet,
    stokeslet,
    stokeslet_gradient,
    stokeslet_matrix,
    stokeslet_slopes,
    stresslet,
    stresslet_gradients,
    stresslet_matrix,
    stresslet_of_dyad,
    stresslet_slopes,
)
from celltrain.flow.ewald import near_scalars, near_stress_scalars

XI = 0.9
D, F, W, N = jnp.asarray(np.random.default_rng(8).normal(size=(4, 3)))


def scalars(d: np.ndarray) -> tuple[jax.Array, jax.Array]:
    return near_scalars(dot(d, d), XI)


def stress(d: np.ndarray) -> tuple[jax.Array, jax.Array]:
    return near_stress_scalars(dot(d, d), XI)


def of_force(d: jax.Array) -> jax.Array:
    return jnp.stack(stokeslet(scalars(d), d, F))


def of_density(d: jax.Array, normal: jax.Array) -> jax.Array:
    return jnp.stack(stresslet(stress(d), d, W, normal))


def unfolded(matrix: list[jax.Array]) -> np.ndarray:
    return np.asarray(jnp.stack(matrix))[UNFOLD]


def test_the_stokeslet_in_free_space() -> None:
    r = np.linalg.norm(D)
    expected = F / r + D * (D @ F) / r**3
    assert_allclose(stokeslet((1 / r, 1 / r**3), D, F), expected, rtol=1e-14)


def test_the_stresslet_in_free_space() -> None:
    square = D @ D
    cubic = free_stresslet(square, square**-0.5)
    # T(y - x) = -T(d).
    expected = 6 * D * (D @ W) * (D @ N) / square**2.5
    assert_allclose(stresslet((0.0, cubic), D, W, N), expected, rtol=1e-14)


def test_the_stresslet_is_the_stress_of_the_stokeslet() -> None:
    # T_ijk = -delta_ik p_j + d_k G_ij + d_i G_kj; here without the pressure: i, k unequal.
    slope = jax.jacfwd(lambda d: unfold_jax(stokeslet_matrix(scalars(d), d)))(jnp.asarray(D))
    linear, cubic = stress(D)
    for i, j, k in ((0, 1, 2), (1, 1, 2), (0, 2, 2), (2, 0, 1)):
        if i == k:
            continue
        expected = slope[i, j, k] + slope[k, j, i]
        eye = np.eye(3)
        found = linear * (eye[i, j] * D[k] + eye[j, k] * D[i] + eye[i, k] * D[j])
        found = found + cubic * D[i] * D[j] * D[k]
        assert_allclose(found, expected, rtol=1e-9)


def unfold_jax(matrix: list[jax.Array]) -> jax.Array:
    return jnp.stack(matrix)[UNFOLD]


def test_matrices_do_what_the_kernels_do() -> None:
    assert_allclose(unfolded(stokeslet_matrix(scalars(D), D)) @ F, of_force(D), rtol=1e-13)
    linear, cubic = stress(D)
    through = D @ N
    matrix = unfolded(stresslet_matrix(linear, cubic * through, through, D, N))
    assert_allclose(matrix @ W, of_density(D, N), rtol=1e-13)


def test_dyads_do_what_density_and_normal_do() -> None:
    dyad = np.outer(W, N) + np.outer(N, W)
    kept = dyad[[0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]]
    assert_allclose(stresslet_of_dyad(stress(D), D, kept), of_density(D, N), rtol=1e-13)


@pytest.mark.parametrize("scale", [0.05, 1.0, 2.5])
def test_gradients(scale: float) -> None:
    d = jnp.asarray(scale * D)
    square = dot(d, d)
    slopes = stokeslet_slopes(scalars(d), stress(d))
    found = np.reshape(stokeslet_gradient(scalars(d), slopes, d, F), (3, 3))
    expected = jax.jacfwd(of_force)(d)
    assert_allclose(found, expected, rtol=0, atol=1e-10 * np.abs(expected).max())

    slopes = stresslet_slopes(stress(d), square, XI)
    by_d, by_normal = stresslet_gradients(stress(d), slopes, d, W, N)
    for found, number in ((by_d, 0), (by_normal, 1)):
        expected = jax.jacfwd(of_density, argnums=number)(d, jnp.asarray(N))
        size = np.abs(expected).max()
        assert_allclose(np.reshape(found, (3, 3)), expected, rtol=0, atol=1e-9 * size)
