"""Rigid spheres on the axis of a tube, against series solutions.

A rigid sphere is had from a membrane at rest in the shape of a sphere: the axisymmetric force
density that gives all its points the same velocity.
"""

from collections.abc import Callable
from dataclasses import dataclass

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain import Train
from celltrain.harmonics import UNIT_DISPLACEMENT, axisymmetric_basis
from celltrain.train import CellsOperator, resting_shapes, train_operator

DEGREE = 12
BASIS = jnp.asarray(axisymmetric_basis(DEGREE))
#: From forces to net force: member 0 is a constant along the tube.


@dataclass(frozen=True)
class RigidSphere:
    """Forces (coefficients) on a sphere of radius 1 and what they do."""

    operator: CellsOperator
    mobility: np.ndarray
    moving: np.ndarray
    held: np.ndarray

    @property
    def drag_moving(self) -> float:
        """Force that drives it at unit speed through fluid without mean flow, over 6 pi."""
        return float(self.moving[0]) * UNIT_DISPLACEMENT / (6 * np.pi)

    @property
    def drag_held(self) -> float:
        """Force that holds it in Poiseuille flow, over 6 pi times the speed on the axis, 2."""
        return -float(self.held[0]) * UNIT_DISPLACEMENT / (6 * np.pi) / 2


@eqx.filter_jit
def mobility_and_flow(operator: CellsOperator, shapes: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Velocities by each member of the basis as a force, one a row, and without any force."""
    targets = operator.targets(shapes)

    def velocity(forces: jax.Array) -> jax.Array:
        total = operator.own_velocity(targets, shapes, forces)
        total = total + operator.outer_velocity(targets, shapes, forces)
        return jnp.einsum("uik,ik->u", BASIS, operator.project(total)[0])

    flow = velocity(jnp.zeros_like(shapes))
    return jax.lax.map(lambda member: velocity(member[None]) - flow, BASIS), flow


@pytest.fixture(scope="module")
def rigid_sphere() -> Callable[[float, float], RigidSphere]:
    """A sphere of given radius and period, both over the tube's radius."""

    def make(size: float, period: float) -> RigidSphere:
        train = Train(
            diameter=2 / size,
            packing=size / period,
            cells=1,
            reference="sphere",
            degree=DEGREE,
            tolerance=1e-7,
            polar_radial=32,
            polar_azimuthal=40,
        )
        operator = train_operator(train, close=False)
        shapes = jnp.asarray(resting_shapes(train, 1))
        by_row, flow = (np.asarray(each) for each in mobility_and_flow(operator, shapes))
        upward = np.zeros(len(BASIS))
        upward[0] = UNIT_DISPLACEMENT
        # A uniform pressure moves nothing: least squares leaves it out.
        moving, held = np.linalg.lstsq(by_row.T, np.stack([upward, -flow], axis=1), rcond=1e-9)[0].T
        return RigidSphere(operator, by_row.T, moving, held)

    return make


@pytest.mark.parametrize(
    ("size", "moving", "held"),
    [(0.3, 2.370094890, 2.228976606), (0.5, 5.947374246, 4.995338624)],
)
def test_drag_in_a_long_tube(
    size: float, moving: float, held: float, rigid_sphere: Callable[[float, float], RigidSphere]
) -> None:
    # The table is for an infinite tube; the flow rate through a periodic one is held, which for a
    # sphere in ten radii of tube changes nothing in these digits.
    sphere = rigid_sphere(size, 10.0)
    assert_allclose(sphere.drag_moving, moving, rtol=5e-8)
    assert_allclose(sphere.drag_held, held, rtol=5e-8)
    # Reciprocity.
    mobility = sphere.mobility
    assert_allclose(mobility, mobility.T, rtol=0, atol=1e-7 * np.abs(mobility).max())


def test_train_of_free_spheres(rigid_sphere: Callable[[float, float], RigidSphere]) -> None:
    sphere = rigid_sphere(0.5, 2.0)
    speed = sphere.drag_held * 2 / sphere.drag_moving
    assert_allclose(speed, 1.6789619, rtol=2e-7)
    free = speed * sphere.moving + sphere.held
    assert abs(free[0]) < 1e-9
    forces = jnp.einsum("u,uik->ik", jnp.asarray(free), BASIS)[None]
    shapes = sphere.operator.membrane.reference_shape[None]
    viscosity = sphere.operator.effective_viscosity(shapes, forces)
    assert_allclose(viscosity, 1.0323471, rtol=2e-7)
