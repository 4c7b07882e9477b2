"""The equations of steady trains as curves and searches take them.

Unknowns are those of a steady train (see `steady.system`) in units of a displacement by one r0,
a/sqrt(4 pi), and the multiplier c that takes the place of the equation which follows from the
others; c = 0 in a solution. The equations are

    F(a, c) = [ v(a) - c n,  V(a) - V0 ],      n = dV/da.
"""

import math

import jax.numpy as jnp
import numpy as np

from celltrain.continuation.arclength import Evaluation, NoSolution, Unknowns
from celltrain.parameters import Train
from celltrain.steady import Base
from celltrain.steady.solve import describe
from celltrain.steady.system import SteadySystem
from celltrain.train import largest_radius, streamwise_gap

# A displacement by one r0 in the coefficients.
UNIT = math.sqrt(4.0 * math.pi)


def to_unknowns(system: SteadySystem, shape: np.ndarray) -> Unknowns:
    """(a/sqrt(4 pi), c = 0) of an axisymmetric shape."""
    return np.append(np.asarray(system.unknowns(jnp.asarray(shape))) / UNIT, 0.0)


def evaluate_steady(
    system: SteadySystem, train: Train, unknowns: Unknowns, origin: str
) -> Evaluation[Base]:
    """F, its derivatives in the unknowns, and the train that belongs to them.

    **Raises:** `NoSolution` where cells overlap each other or the wall.
    """
    amounts = jnp.asarray(UNIT * unknowns[:-1])
    shape = np.asarray(system.shape(amounts))
    # The gap is the smallest radius by radius: what is not a number has none.
    if not (streamwise_gap(shape, train.period) > 0.0 and largest_radius(shape) < train.radius):
        raise NoSolution("cells overlap")
    state = system.state(amounts)
    rates, normal = np.asarray(state.rates), np.asarray(state.volume_gradient)
    membrane = system.operator.membrane
    missing = float(state.volume) - float(membrane.volume(membrane.reference_shape))
    size = len(rates)
    jacobian = np.zeros((size + 1, size + 1))
    jacobian[:size, :size] = UNIT * np.asarray(state.jacobian)
    jacobian[:size, size] = -normal
    jacobian[size, :size] = UNIT * normal
    return Evaluation(
        residual=np.append(rates - unknowns[-1] * normal, missing),
        jacobian=jacobian,
        error=max(float(state.residual), abs(missing)),
        state=describe(system, train, np.asarray(amounts), state, (), origin),
    )
