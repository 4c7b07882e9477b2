"""How a steady train changes with its parameters, exactly.

The steady equations v(a, p) = 0 (see `problem`) define the shape a(p) at the volume V0 of the cell
at rest, which only the reduced volume changes:

    [ -J   n ] [ da/dp ]   [ dv/dp  ]
    [ n^T  0 ] [   .   ] = [ dV0/dp ],

with J and n at the solution and dv/dp at fixed shape and fixed rules (see `varied`). Cell velocity
and effective viscosity change along (da/dp, 1). Nothing depends on the viscosity ratio: a steady
train's cells move rigidly.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from jaxtyping import Float

from celltrain.harmonics import UNIT_DISPLACEMENT, Profile, coefficients_of
from celltrain.quantities import Quantity, Record
from celltrain.steady.base import Base
from celltrain.steady.parameters import check_parameters, parameters_of
from celltrain.steady.problem import SteadyProblem, Unknowns, change_of_profile
from celltrain.steady.varied import VariedTrain


@dataclass(frozen=True, eq=False)
class BaseSensitivity(Record):
    """Derivatives of a steady train by one parameter, in the parameter's and the quantity's units.

    `residual` is the largest rate of change left by the derivative of the shape, relative to the
    parameter's own: how exactly the linear equations are solved.
    """

    parameter: Annotated[str, Quantity("p", "1", "name of the parameter")]
    coefficients: Annotated[
        Float[np.ndarray, "3 coefficient"],
        Quantity(
            "ds/dp",
            "r0 per parameter",
            "derivative of the shape",
            ("axis", "coefficient"),
            bulky=True,
        ),
    ]
    cell_velocity: Annotated[
        float, Quantity("dU_c/dp", "U per parameter", "derivative of the cell velocity")
    ]
    effective_viscosity: Annotated[
        float,
        Quantity(
            r"d\mu_\mathrm{eff}/dp", "mu per parameter", "derivative of the effective viscosity"
        ),
    ]
    residual: Annotated[
        float,
        Quantity("", "1", "relative rate of change left by the derivative of the shape"),
    ]


def base_sensitivities(
    base: Base, parameters: Sequence[str] | None = None
) -> dict[str, BaseSensitivity]:
    """Derivatives of a steady train by its parameters.

    They are those of the discrete equations at fixed grids and rules (see the module).

    **Arguments:** `parameters`: names among `PARAMETERS`, all that the train has if not given;
    lengths in r0, moduli in mu U.

    **Raises:** `CaseError` for a parameter that is not allowed.
    """
    names = parameters_of(base.train) if parameters is None else tuple(parameters)
    check_parameters(names, base.train)
    problem = SteadyProblem(base.train)
    profile = base.profile
    bordered = problem.state(profile).bordered()
    return {name: _sensitivity(problem, profile, name, bordered) for name in names}


def rates_by_parameter(varied: VariedTrain, profile: Profile) -> tuple[Unknowns, float]:
    """dv/dp of the steady equations at a fixed shape, and dV0/dp."""
    inner = slice(1, 2 * profile.shape[1] - 1)
    rates = varied.derivative(lambda change: varied.flow(change, profile).rates[inner])
    return rates, varied.derivative(varied.volume)


def _sensitivity(
    problem: SteadyProblem,
    profile: Profile,
    name: str,
    bordered: Float[np.ndarray, "size size"],
) -> BaseSensitivity:
    if name == "viscosity_ratio":
        still = coefficients_of(np.zeros_like(profile))
        return BaseSensitivity(name, still, 0.0, 0.0, 0.0)
    varied = VariedTrain(problem, profile, name)
    rates, volume = rates_by_parameter(varied, profile)
    slope = change_of_profile(np.linalg.solve(bordered, np.append(rates, volume))[:-1])

    def along(change: float) -> np.ndarray:
        flow = varied.flow(change, profile + change * slope)
        return np.append(flow.rates[: 2 * flow.degree - 1], flow.effective_viscosity)

    changes = varied.derivative(along)
    size = float(np.abs(rates).max())
    return BaseSensitivity(
        parameter=name,
        coefficients=coefficients_of(slope),
        cell_velocity=float(changes[0]) / UNIT_DISPLACEMENT,
        effective_viscosity=float(changes[-1]),
        residual=float(np.abs(changes[1:-1]).max()) / size if size > 0.0 else 0.0,
    )
