"""How a steady train changes with its parameters, exactly.

The steady equations F(a, p) = 0 (see `system`) define the shape a(p) at the volume V0 of the cell
at rest, which only the reduced volume changes:

    [ -J   n ] [ da/dp ]   [ dv/dp  ]
    [ n^T  0 ] [   .   ] = [ dV0/dp ],

with J and n at the solution and dv/dp at fixed shape and fixed rules (see `Variation`). Cell
velocity and effective viscosity change along (da/dp, 1). Nothing depends on the viscosity ratio: a
steady train's cells move rigidly.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from celltrain.steady.base import Base
from celltrain.steady.solve import comes_close
from celltrain.steady.system import SteadySystem, bordered_matrix, steady_system
from celltrain.train import Variation, check_parameters, parameters_of, variation


@dataclass(frozen=True)
class BaseSensitivity:
    """Derivatives of a steady train by one parameter, in the parameter's and the quantity's units.

    `residual` is the largest rate of change left by the derivative of the shape, relative to the
    parameter's own: how exactly the linear equations are solved.
    """

    parameter: str
    coefficients: Float[np.ndarray, "3 coefficient"]
    cell_velocity: float
    effective_viscosity: float
    residual: float


def base_sensitivities(
    base: Base, parameters: Sequence[str] | None = None
) -> dict[str, BaseSensitivity]:
    """Derivatives of a steady train by its parameters.

    They are those of the discrete equations at fixed grids and rules, to rounding (see the module).

    **Arguments:** `parameters`: names among `PARAMETERS`, all that the train has if not given;
    lengths in r0, moduli in mu U.

    **Raises:** `CaseError` for a parameter that is not allowed.
    """
    train = base.train
    names = parameters_of(train) if parameters is None else tuple(parameters)
    check_parameters(names, train)
    system = steady_system(train, close=comes_close(train, base.coefficients))
    unknowns = system.unknowns(jnp.asarray(base.coefficients))
    varied = variation(system.operator, train, names)
    matrix = bordered_matrix(system.state(unknowns), math.inf)
    right, volumes = rates_by_parameters(system, varied, names, unknowns)
    padded = np.concatenate([right, volumes[:, None]], axis=1)
    slopes = np.linalg.solve(matrix, padded.T).T[:, :-1]
    changes, viscosities, _ = _changes(system, varied, names, unknowns, jnp.asarray(slopes))
    left = np.abs(np.asarray(jax.vmap(system.unknowns)(changes))).max(axis=1)
    size = np.abs(right).max(axis=1)
    found = {}
    for i, name in enumerate(names):
        upward = float(jnp.sum(changes[i] * system.upward))
        found[name] = BaseSensitivity(
            parameter=name,
            coefficients=np.asarray(system.shape(jnp.asarray(slopes[i]))),
            cell_velocity=upward / math.sqrt(4.0 * math.pi),
            effective_viscosity=float(viscosities[i]),
            residual=float(left[i] / size[i]) if size[i] > 0.0 else 0.0,
        )
    return found


def rates_by_parameters(
    system: SteadySystem,
    varied: Variation,
    names: tuple[str, ...],
    unknowns: Float[Array, " unknown"],
) -> tuple[Float[np.ndarray, "parameter unknown"], Float[np.ndarray, " parameter"]]:
    """dv/dp of the steady equations at fixed shape, and dV0/dp."""
    still = jnp.zeros((len(names), unknowns.size))
    changes, _, volumes = _changes(system, varied, names, unknowns, still)
    return np.asarray(jax.vmap(system.unknowns)(changes)), np.asarray(volumes)


@eqx.filter_jit
def _changes(
    system: SteadySystem,
    varied: Variation,
    names: tuple[str, ...],
    unknowns: Float[Array, " unknown"],
    slopes: Float[Array, "parameter unknown"],
) -> tuple[
    Float[Array, "parameter 3 coefficient"], Float[Array, " parameter"], Float[Array, " parameter"]
]:
    """Changes of rates, viscosity and volume at rest along each parameter and its change of the
    unknowns.
    """

    def observed(values: Array, unknowns: Array) -> tuple[Array, Array, Array]:
        operator = varied.at(dict(zip(names, values, strict=True)))
        moved, (_, viscosity) = system.rates(operator, unknowns)
        membrane = operator.membrane
        return moved, viscosity, membrane.volume(membrane.reference_shape)

    start = jnp.stack([varied.start[name] for name in names])

    def change(along: Array, slope: Array) -> tuple[Array, Array, Array]:
        found: tuple[Array, Array, Array]
        found = jax.jvp(observed, (start, unknowns), (along, slope))[1]
        return found

    return jax.vmap(change)(jnp.eye(len(names)), slopes)
