"""GMRES that stops as soon as it may, says how far it came, and has an implicit derivative.

JAX's own needs the transpose of the operator even if only the solution is asked for, which sums
over a number of pairs that depends on the data do not have; Lineax's looks at the residual only
when it restarts. Method: Saad & Schultz 1986, with each new vector made orthogonal twice, so that
the residual in its recurrence is the true one up to rounding and need not be computed again.

The operators here are preconditioned, A = 1 - E with a small E. With r the residual of x, that of
x + r is E r, about |E| |r|: the correction that one more iteration would bring is had without it.
|E| is taken to be four times the largest |E v| of the vectors of the basis, of which there must be
two: the right side is mostly a rigid motion, of which E makes nothing. Nothing is corrected where
that is not below 1, as it is not at large viscosity ratios. It is an estimate: the direction of r
is not among them.
"""

from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
import jax.scipy.linalg
from jaxtyping import Array, Float, Int

Operator = Callable[[Array], Array]


class Iterations(eqx.Module):
    """Applications of the operator, and an estimate of the residual relative to |b|."""

    iterations: Int[Array, ""]
    residual: Float[Array, ""]


class _Arnoldi(eqx.Module):
    """Orthonormal basis, triangular factor of the projected operator, rotations that made it so.

    `images`: what the operator gives of the basis; `change`: the largest difference between a
    vector and its image.
    """

    basis: Float[Array, "vector size"]
    images: Float[Array, "step size"]
    change: Float[Array, ""]
    triangle: Float[Array, "step step"]
    cosine: Float[Array, " step"]
    sine: Float[Array, " step"]
    right: Float[Array, " vector"]
    step: Int[Array, ""]


def gmres(
    operator: Operator,
    right: Float[Array, "..."],
    *,
    tolerance: float | Float[Array, ""],
    iterations: int,
) -> tuple[Float[Array, "..."], Iterations]:
    """Solution x of A x = b, starting from 0.

    Two right sides that differ little have solutions whose errors do too: a simulation's rates are
    such a difference.

    Derivatives (forward) solve the same equation for other right sides.

    **Arguments:** `tolerance`: of the residual relative to |b|; `iterations`: at most.
    """

    def solve(matvec: Operator, right: Array) -> tuple[Array, Iterations]:
        return _solve(matvec, right, tolerance, iterations)

    solution, convergence = jax.lax.custom_linear_solve(operator, right, solve, has_aux=True)
    return solution, jax.lax.stop_gradient(convergence)


def _solve(
    operator: Operator, right: Array, tolerance: float | Float[Array, ""], iterations: int
) -> tuple[Array, Iterations]:
    flat = right.ravel()
    scale = jnp.linalg.norm(flat)
    start = _Arnoldi(
        basis=jnp.zeros((iterations + 1, flat.size)).at[0].set(flat / _safe(scale)),
        images=jnp.zeros((iterations, flat.size)),
        change=jnp.array(0.0),
        triangle=jnp.eye(iterations),
        cosine=jnp.ones(iterations),
        sine=jnp.zeros(iterations),
        right=jnp.zeros(iterations + 1).at[0].set(scale),
        step=jnp.array(0),
    )

    def goes_on(state: _Arnoldi) -> Array:
        return (_residual(state) > tolerance * scale) & (state.step < iterations)

    def on(state: _Arnoldi) -> _Arnoldi:
        # The operator is large to compile: it is here alone.
        image = operator(state.basis[state.step].reshape(right.shape))
        return _extended(image.ravel(), state)

    last = jax.lax.while_loop(goes_on, on, start)
    # Steps that were not taken have ones on the diagonal and nothing on the right.
    used = jnp.where(jnp.arange(iterations) < last.step, last.right[:-1], 0.0)
    amounts = jax.scipy.linalg.solve_triangular(last.triangle, used)
    solution = amounts @ last.basis[:-1]
    corrected = solution + (flat - amounts @ last.images)
    solution = jnp.where(_reduction(last) < 1.0, corrected, solution)
    return solution.reshape(right.shape), Iterations(last.step, _residual(last) / _safe(scale))


def _reduction(state: _Arnoldi) -> Float[Array, ""]:
    """Of the residual by the last correction; 1 where there is none."""
    return jnp.where(state.step > 1, jnp.minimum(1.0, 4.0 * state.change), 1.0)


def _residual(state: _Arnoldi) -> Float[Array, ""]:
    """The residual after the last correction."""
    return _reduction(state) * jnp.abs(state.right[state.step])


def _extended(image: Array, state: _Arnoldi) -> _Arnoldi:
    """One more vector of the basis, one more column of the triangle.

    **Arguments:** `image`: what the operator gives of the basis's last vector.
    """
    step, basis = state.step, state.basis
    images = state.images.at[step].set(image)
    change = jnp.maximum(state.change, jnp.linalg.norm(image - basis[step]))
    column = basis @ image
    image = image - column @ basis
    again = basis @ image
    image = image - again @ basis
    column = column + again
    length = jnp.linalg.norm(image)

    def rotate(i: Array, column: Array) -> Array:
        here, below = column[i], column[i + 1]
        turned = column.at[i].set(state.cosine[i] * here + state.sine[i] * below)
        turned = turned.at[i + 1].set(state.cosine[i] * below - state.sine[i] * here)
        return jnp.where(i < step, turned, column)

    column = jax.lax.fori_loop(0, state.cosine.size, rotate, column.at[step + 1].set(length))
    size = jnp.hypot(column[step], column[step + 1])
    cosine, sine = column[step] / _safe(size), column[step + 1] / _safe(size)
    place = jnp.arange(state.cosine.size)
    column = jnp.where(place < step, column[:-1], jnp.where(place == step, _safe(size), 0.0))
    right = state.right[step]
    return _Arnoldi(
        basis=basis.at[step + 1].set(image / _safe(length)),
        images=images,
        change=change,
        triangle=state.triangle.at[:, step].set(column),
        cosine=state.cosine.at[step].set(cosine),
        sine=state.sine.at[step].set(sine),
        right=state.right.at[step].set(cosine * right).at[step + 1].set(-sine * right),
        step=step + 1,
    )


def _safe(length: Array) -> Array:
    return jnp.where(length > 0.0, length, 1.0)
