"""A train whose parameters vary while all rules stay as they are.

Differences of what the discrete equations give are smooth in the parameters only if nothing is
chosen anew: the grids and polar rules are those of the train itself, and what ends the sums of wall
and tail, whose lengths follow the tube and the shape, is far below what is differenced. Resting
shapes of other reduced volumes are taken to first order, which is all that derivatives ask for.

Derivatives are central differences over a step h and half of it, extrapolated,

    f' = [4 d(h/2) - d(h)]/3,   d(h) = [f(p + h) - f(p - h)]/(2 h),

with an error of fourth order in h over the distance at which f changes: h is a small part of the
room between the cell and the wall, and between cells.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

import numpy as np

from celltrain.harmonics import Profile, profile_of
from celltrain.harmonics.grading import regraded
from celltrain.membrane import (
    AxisymmetricMembrane,
    axisymmetric_membrane,
    relaxed_slope,
    with_moduli,
)
from celltrain.meridian.geometry import largest_radius
from celltrain.meridian.rules import Rules
from celltrain.meridian.train import SMALLEST_PHASE, TrainFlow
from celltrain.parameters.strength import weakened
from celltrain.proximity.meridian import streamwise_gap
from celltrain.steady.parameters import MATERIAL, parameter_value
from celltrain.steady.problem import SteadyProblem

Differenced = TypeVar("Differenced", float, np.ndarray)

#: Tolerance of the sums while differences are taken: their lengths jump.
SHARP = 1e-13
#: Step over the room that the cells have, relative to the parameter.
STEP = 2.5e-3


class VariedTrain:
    """Flow and volume of a train's cells at other values of one parameter.

    **Arguments:** `problem` of the train; `profile`: a shape of its cells, which sets the rules and
    the step; `parameter`: one of `PARAMETERS`.

    **Raises:** `CaseError` if the train does not have the parameter, or has no derivative by it.
    """

    def __init__(self, problem: SteadyProblem, profile: Profile, parameter: str) -> None:
        train = problem.train
        self._problem, self._parameter = problem, parameter
        self.value = parameter_value(train, parameter)
        self.rules: Rules = replace(problem.rules(profile), tolerance=SHARP)
        beside = 1.0 - largest_radius(profile) / train.radius
        between = streamwise_gap(profile, train.period) / train.period
        # Rates are proportional to moduli: any step serves where one is zero.
        self.step = STEP * max(min(beside, between), STEP) * (abs(self.value) or 1.0)
        self._rest_slope: Profile | None = None
        if parameter == "reduced_volume":
            slope = profile_of(relaxed_slope(train.degree, self.value))
            self._rest_slope = regraded(slope, 0.0, train.resolution.grading)

    def flow(
        self,
        change: float,
        profile: Profile,
        *,
        largest_azimuthal_number: int = 0,
        smallest_phase: float = SMALLEST_PHASE,
    ) -> TrainFlow:
        """The flow about a shape with the parameter changed."""
        train, value = self._problem.train, self.value + change
        return TrainFlow(
            self.membrane(change),
            profile,
            radius=0.5 * value if self._parameter == "diameter" else train.radius,
            period=1.0 / value if self._parameter == "packing" else train.period,
            rules=self.rules,
            largest_azimuthal_number=largest_azimuthal_number,
            smallest_phase=smallest_phase,
        )

    def membrane(self, change: float) -> AxisymmetricMembrane:
        """The cells' membrane with the parameter changed."""
        membrane, train = self._problem.membrane, self._problem.train
        if self._rest_slope is not None:
            return axisymmetric_membrane(
                membrane.law,
                membrane.bending,
                membrane.rest_profile + change * self._rest_slope,
                energy_order=train.sizes.energy_order,
            )
        if self._parameter in MATERIAL:
            moduli = {self._parameter: self.value + change}
        elif self._parameter == "capillary_number":
            moduli = weakened(train.leaves(), self.value / (self.value + change))
        else:
            return membrane
        return replace(
            membrane,
            law=with_moduli(membrane.law, moduli),
            bending=with_moduli(membrane.bending, moduli),
        )

    def volume(self, change: float) -> float:
        """Volume of the cell at rest with the parameter changed, r0^3."""
        membrane = self.membrane(change)
        return membrane.volume(membrane.rest_profile)

    def derivative(self, function: Callable[[float], Differenced]) -> Differenced:
        """The derivative of a function of the parameter's change (see the module)."""
        far, near = ((function(h) - function(-h)) / (2.0 * h) for h in (self.step, 0.5 * self.step))
        return (4.0 * near - far) / 3.0
