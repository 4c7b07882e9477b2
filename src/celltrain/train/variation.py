"""Operators whose parameters vary while all grids and rules stay as they are.

A tube's radius R and period L enter through arrays only: the box (2 R + cutoff, 2 R + cutoff, L) of
the Ewald sums, the places of the wall's points, and the response of the wall, which depends on k R
~ R/L alone and is taken to first order. So derivatives by the diameter and the packing are exact
derivatives of the discrete rates, as those by the moduli are, and by the reduced volume, with which
the resting shape changes (`relaxed_slope`, to first order). What they leave out is that a train
at other parameters chooses finer or coarser rules, each within its tolerance.
"""

from collections.abc import Mapping, Sequence

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from celltrain.membrane import relaxed_slope, with_moduli
from celltrain.membrane.energy import Membrane
from celltrain.parameters import Train
from celltrain.train.operator import TrainOperator
from celltrain.train.parameters import MODULI, PARAMETERS, parameter_value

Values = Mapping[str, Float[Array, ""]]


class Variation(eqx.Module):
    """An operator of a train, as a function of the train's parameters at fixed rules.

    `start` are the values at which it was made, `slope` that of the wall's response, `rest_slope`
    that of the resting shape with the reduced volume, if that is among the parameters.
    """

    operator: TrainOperator
    start: dict[str, Float[Array, ""]]
    slope: Float[Array, "3 3 m k chebyshev"]
    rest_slope: Float[Array, "3 coefficient"] | None

    def at(self, values: Values) -> TrainOperator:
        """The operator at other values of some parameters, exact to first order about the start.

        The viscosity ratio is not among those that it has: what it does follows from the operator
        at equal viscosities.
        """
        value = {**self.start, **values}
        tube = self.operator.tube
        radius = 0.5 * value["diameter"]
        period = tube.wall.period * self.start["packing"] / value["packing"]
        width = 2.0 * radius + tube.split.cutoff
        resized = eqx.tree_at(
            lambda each: (each.transform.box, each.wall),
            tube,
            (jnp.stack([width, width, period]), tube.wall.resized(radius, period, self.slope)),
        )
        return eqx.tree_at(
            lambda each: (each.membrane, each.tube), self.operator, (self._membrane(value), resized)
        )

    def _membrane(self, value: Values) -> Membrane:
        # All moduli are in inverse proportion to the strength of the flow.
        weaker = self.start["capillary_number"] / value["capillary_number"]
        moduli = {name: weaker * value[name] for name in MODULI}
        membrane = self.operator.membrane
        membrane = eqx.tree_at(
            lambda each: (each.law, each.bending),
            membrane,
            (with_moduli(membrane.law, moduli), with_moduli(membrane.bending, moduli)),
        )
        if self.rest_slope is None:
            return membrane
        more = value["reduced_volume"] - self.start["reduced_volume"]
        return membrane.at_rest_in(membrane.reference_shape + more * self.rest_slope)


def variation(operator: TrainOperator, train: Train, names: Sequence[str]) -> Variation:
    """The operator of a train as a function of its parameters, those of `names` at least.

    **Raises:** `CaseError` if it cannot be differentiated by the reduced volume that it has.
    """
    named = [name for name in PARAMETERS if name != "reduced_volume" or name in names]
    start = {name: parameter_value(train, name) for name in named}
    rest_slope = None
    if "reduced_volume" in start:
        rest_slope = jnp.asarray(relaxed_slope(train.degree, start["reduced_volume"]))
    return Variation(
        operator=operator,
        start={name: jnp.asarray(value) for name, value in start.items()},
        slope=jnp.asarray(operator.tube.wall.response_slope()),
        rest_slope=rest_slope,
    )
