"""GMRES on matrices whose solution is known."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain.train.gmres import gmres


def problem(size: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """A matrix that is neither symmetric nor close to the identity, and a right side."""
    random = np.random.default_rng(0)
    matrix = np.eye(size) + 0.5 * random.normal(size=(size, size)) / np.sqrt(size)
    return matrix, random.normal(size=size)


def test_solution_residual_and_count() -> None:
    matrix, right = problem()

    def solve(tolerance: float, iterations: int = 40):
        return gmres(
            lambda x: (jnp.asarray(matrix) @ x.ravel()).reshape(x.shape),
            jnp.asarray(right).reshape(4, 10),
            tolerance=tolerance,
            iterations=iterations,
        )

    counts = []
    for tolerance in (1e-3, 1e-6, 1e-12):
        solution, convergence = solve(tolerance)
        residual = np.linalg.norm(matrix @ solution.ravel() - right) / np.linalg.norm(right)
        assert 1e-3 * tolerance < residual < tolerance
        # No correction here, where the matrix is far from 1: it is that of the recurrence.
        assert_allclose(convergence.residual, residual, rtol=1e-2)
        counts.append(int(convergence.iterations))
    assert counts[0] < counts[1] < counts[2] <= 40
    _, convergence = solve(1e-12, iterations=5)
    assert convergence.iterations == 5
    assert convergence.residual > 1e-4


def test_close_to_one_the_last_correction_takes_no_iteration() -> None:
    """Each iteration takes the residual to a hundredth: 1e-5 would take three of them."""
    matrix, right = problem()
    matrix = np.eye(len(right)) + 0.02 * (matrix - np.eye(len(right)))
    for tolerance, iterations in ((1e-1, 1), (1e-3, 2), (1e-5, 2), (1e-7, 3)):
        solution, convergence = gmres(
            lambda x: jnp.asarray(matrix) @ x,
            jnp.asarray(right),
            tolerance=tolerance,
            iterations=9,
        )
        residual = np.linalg.norm(matrix @ solution - right) / np.linalg.norm(right)
        assert int(convergence.iterations) == iterations
        assert 0.05 * convergence.residual < residual
        assert residual < 1.01 * convergence.residual < tolerance


@pytest.mark.parametrize("norm", [0.02, 0.1, 0.3])
def test_the_estimate_keeps_to_the_tolerance(norm: float) -> None:
    """Of matrices far from normal, and of right sides that they leave as they are but for 1e-3."""
    random, size, tolerance = np.random.default_rng(0), 30, 1e-7

    @jax.jit
    def solve(matrix: jax.Array, right: jax.Array) -> jax.Array:
        return gmres(lambda x: matrix @ x, right, tolerance=tolerance, iterations=20)[0]

    for _ in range(200):
        left, other = np.exp(-random.uniform(0, 4, (2, size)))
        change = left[:, None] * random.normal(size=(size, size)) * other
        right = 1e-3 * random.normal(size=size)
        change[:, 0], right[0] = 0.0, 1.0
        matrix = np.eye(size) - norm * change / np.linalg.norm(change, 2)
        solution = np.asarray(solve(matrix, right))
        residual = np.linalg.norm(matrix @ solution - right) / np.linalg.norm(right)
        assert residual < tolerance


def test_few_eigenvalues_take_few_iterations() -> None:
    diagonal = jnp.asarray(np.repeat([1.0, 2.0, 7.0], 12))
    solution, convergence = gmres(
        lambda x: diagonal * x, jnp.ones(36), tolerance=1e-12, iterations=20
    )
    assert_allclose(solution, 1 / diagonal, rtol=1e-11)
    assert convergence.iterations == 3


def test_exact_at_once() -> None:
    right = jnp.arange(5.0)
    solution, convergence = gmres(lambda x: x, right, tolerance=1e-12, iterations=4)
    assert_allclose(solution, right)
    assert convergence.iterations == 1
    nothing, convergence = gmres(lambda x: 2 * x, jnp.zeros(5), tolerance=1e-12, iterations=4)
    assert_allclose(nothing, 0.0)
    assert convergence.iterations == 0


def test_nothing_is_tried_with_what_is_not_finite() -> None:
    right = jnp.ones(5).at[3].set(jnp.nan)
    _, found = gmres(lambda x: 2 * x, right, tolerance=1e-8, iterations=40)
    assert int(found.iterations) == 0
    assert np.isnan(found.residual)


def test_derivative_is_implicit() -> None:
    matrix, right = problem()
    slope = np.random.default_rng(1).normal(size=matrix.shape)

    def solved(amount: jax.Array) -> jax.Array:
        # A sum over as many terms as the data say: without a transpose.
        def operator(x: jax.Array) -> jax.Array:
            count = jnp.where(amount < 10, 2, 3)
            part = (jnp.asarray(matrix) + amount * jnp.asarray(slope)) @ x
            return jax.lax.fori_loop(0, count, lambda _, y: y + 0.5 * part, jnp.zeros_like(x))

        return gmres(operator, jnp.asarray(right), tolerance=1e-13, iterations=40)[0]

    solution, change = jax.jvp(solved, (jnp.array(0.0),), (jnp.array(1.0),))
    assert_allclose(solution, np.linalg.solve(matrix, right), rtol=0, atol=1e-11)
    expected = -np.linalg.solve(matrix, slope @ np.linalg.solve(matrix, right))
    assert_allclose(change, expected, rtol=0, atol=1e-10 * np.abs(expected).max())
