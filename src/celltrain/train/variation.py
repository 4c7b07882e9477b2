"""Operators whose parameters vary while all grids and rules stay as they are.

A tube's radius R and period L enter through arrays only: the box (2 R + cutoff, 2 R + cutoff, L) of
the Ewald sums, the places of the wall's points, and the response of the wall, which depends on k R
~ R/L alone and is taken to first order. So derivatives by the diameter and the packing are exact
derivatives of the discrete rates, as those by the moduli are. What they leave out is that a train
at other parameters chooses finer or coarser rules, each within its tolerance.
"""

from collections.abc import Mapping, Sequence

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from celltrain.membrane.laws import make_law
from celltrain.parameters import CaseError, Train
from celltrain.train.operator import TrainOperator

#: Parameters of a train by which its rates can be differentiated at fixed shapes.
PARAMETERS = (
    "diameter",
    "packing",
    "viscosity_ratio",
    "shear_modulus",
    "dilatation_modulus",
    "bending_modulus",
)

Values = Mapping[str, Float[Array, ""]]


def check_parameters(names: Sequence[str]) -> None:
    """See to it that derivatives by these parameters can be had.

    **Raises:** `CaseError` if not.
    """
    for name in names:
        if name not in PARAMETERS:
            raise CaseError(
                f"parameter = {name!r} is not allowed; allowed: {', '.join(PARAMETERS)}"
            )


class Variation(eqx.Module):
    """An operator of a train, as a function of the train's parameters at fixed rules.

    `start` are the values at which it was made, `slope` that of the wall's response.
    """

    operator: TrainOperator
    start: dict[str, Float[Array, ""]]
    law: str = eqx.field(static=True)
    slope: Float[Array, "3 3 m k chebyshev"]

    def at(self, values: Values) -> TrainOperator:
        """The operator at other values of some parameters, exact to first order about the start.

        The viscosity ratio is not among those that it has: what it does follows from the operator
        at equal viscosities.
        """
        value = {**self.start, **values}
        tube = self.operator.tube
        membrane = eqx.tree_at(
            lambda each: (each.law, each.bending.modulus),
            self.operator.membrane,
            (
                make_law(self.law, value["shear_modulus"], value["dilatation_modulus"]),
                value["bending_modulus"],
            ),
        )
        radius = 0.5 * value["diameter"]
        period = tube.wall.period * self.start["packing"] / value["packing"]
        width = 2.0 * radius + tube.split.cutoff
        resized = eqx.tree_at(
            lambda each: (each.transform.box, each.wall),
            tube,
            (jnp.stack([width, width, period]), tube.wall.resized(radius, period, self.slope)),
        )
        return eqx.tree_at(
            lambda each: (each.membrane, each.tube), self.operator, (membrane, resized)
        )


def variation(operator: TrainOperator, train: Train) -> Variation:
    """The operator of a train as a function of its parameters."""
    start = {name: jnp.asarray(float(train.leaf(name))) for name in PARAMETERS}
    slope = jnp.asarray(operator.tube.wall.response_slope())
    return Variation(operator, start, train.cell.law, slope)
