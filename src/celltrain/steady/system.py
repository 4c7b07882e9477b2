"""The equations of a steady train in the axisymmetric subspace, with their exact derivatives.

Unknowns are the coefficients a of an axisymmetric shape without swirl, s = sum_i a_i b_i, less the
one that moves the cell along the tube. Equations are v_i(s) = 0 for the same i: in the frame of the
cell's mean point nothing moves. Volume is conserved exactly by v, so one equation is a consequence
of the others, and the volume itself takes its place: steps solve the bordered system

    [ 1/dt - J   n ] [ da ]   [ v       ]
    [ n^T        0 ] [ p  ] = [ V0 - V  ],   n = dV/da.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from celltrain.harmonics import axisymmetric_basis
from celltrain.parameters import Train
from celltrain.train import TrainOperator, train_operator


class State(eqx.Module):
    """Velocity, derivatives and what is reported, at one shape."""

    rates: Float[Array, " unknown"]
    jacobian: Float[Array, "unknown unknown"]
    cell_velocity: Float[Array, ""]
    volume: Float[Array, ""]
    volume_gradient: Float[Array, " unknown"]
    residual: Float[Array, ""]
    truncation_error: Float[Array, ""]
    effective_viscosity: Float[Array, ""]


class SteadySystem(eqx.Module):
    """Steady equations of one cell in its period."""

    operator: TrainOperator
    basis: Float[Array, "unknown 3 coefficient"]
    upward: Float[Array, "3 coefficient"]

    def shape(self, unknowns: Float[Array, " unknown"]) -> Float[Array, "3 coefficient"]:
        """Shape with the given unknowns and its mean point at z = 0."""
        return jnp.einsum("u,uik->ik", unknowns, self.basis)

    def unknowns(self, shape: Float[Array, "3 coefficient"]) -> Float[Array, " unknown"]:
        """Unknowns of an axisymmetric shape."""
        return jnp.einsum("uik,ik->u", self.basis, shape)

    def rates(
        self, operator: TrainOperator, unknowns: Float[Array, " unknown"]
    ) -> tuple[Float[Array, "3 coefficient"], tuple[Float[Array, "1 ring 1 3"], Float[Array, ""]]]:
        """Rates of change of the shape; velocity on the target grid and effective viscosity."""
        shapes = self.shape(unknowns)[None]
        forces = operator.forces(shapes)
        velocity = operator.surface_velocity(shapes, forces)
        viscosity = operator.effective_viscosity(shapes, forces)
        moved = operator.conserve_volume(shapes, operator.project(velocity))
        return moved[0], (velocity, viscosity)

    @eqx.filter_jit
    def state(self, unknowns: Float[Array, " unknown"]) -> State:
        """Rates and their derivatives, all directions at once."""
        operator = self.operator

        def rates(unknowns: Array) -> tuple[Array, tuple[Array, Array]]:
            return self.rates(operator, unknowns)

        def tangent(direction: Array) -> tuple[Array, Array, tuple[Array, Array]]:
            return jax.jvp(rates, (unknowns,), (direction,), has_aux=True)

        change, slopes, (velocity, viscosity) = jax.vmap(tangent, out_axes=(None, 0, None))(
            jnp.eye(unknowns.size)
        )
        shape = self.shape(unknowns)
        # A coefficient c of Y_00 is a displacement by c/sqrt(4 pi).
        upward = jnp.sum(change * self.upward)
        cell_velocity = upward / jnp.sqrt(4.0 * jnp.pi)
        on_grid = operator.target_grid.values @ (change - upward * self.upward).T
        uncut = velocity - cell_velocity * jnp.array([0.0, 0.0, 1.0])
        return State(
            rates=self.unknowns(change),
            jacobian=jnp.einsum("uik,vik->vu", slopes, self.basis),
            cell_velocity=cell_velocity,
            volume=operator.membrane.volume(shape),
            volume_gradient=self.unknowns(operator.membrane.volume_gradient(shape)),
            residual=jnp.max(jnp.linalg.norm(on_grid, axis=-1)),
            truncation_error=jnp.max(jnp.linalg.norm(uncut, axis=-1)),
            effective_viscosity=viscosity,
        )


def steady_system(train: Train, *, close: bool) -> SteadySystem:
    """The steady equations of a train, of which cells may be `close` to each other."""
    basis = axisymmetric_basis(train.degree)
    # Cells in steady motion move rigidly: their viscosity plays no part.
    train = train.changed(viscosity_ratio=1.0)
    return SteadySystem(
        operator=train_operator(train, meridian=True, close=close),
        basis=jnp.asarray(basis[1:]),
        upward=jnp.asarray(basis[0]),
    )


def bordered_step(
    state: State, target_volume: float, time_step: float
) -> Float[np.ndarray, " unknown"]:
    """Change of the unknowns by one step of implicit Euler; Newton's step if it is infinite."""
    matrix = bordered_matrix(state, time_step)
    right = np.append(np.asarray(state.rates), target_volume - float(state.volume))
    return np.linalg.solve(matrix, right)[:-1]


def bordered_matrix(state: State, time_step: float) -> Float[np.ndarray, "size size"]:
    """The matrix of a step of implicit Euler, or of Newton's method if the step is infinite."""
    jacobian = np.asarray(state.jacobian)
    size = len(jacobian)
    matrix = np.zeros((size + 1, size + 1))
    matrix[:size, :size] = np.eye(size) / time_step - jacobian
    matrix[:size, size] = matrix[size, :size] = np.asarray(state.volume_gradient)
    return matrix
