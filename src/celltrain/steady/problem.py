"""The equations of a steady train in the axisymmetric subspace, with their exact derivatives.

Unknowns are the coefficients a of an axisymmetric shape without swirl, less the one that moves the
cell along the tube. Equations are v_i(a) = 0 for the same i: in the frame of the cell's mean point
nothing moves. Volume is conserved exactly by v, so one equation is a consequence of the others, and
the volume itself takes its place: steps solve the bordered system

    [ 1/dt - J   n ] [ da ]   [ v       ]
    [ n^T        0 ] [ p  ] = [ V0 - V  ],   n = dV/da.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from celltrain.harmonics import UNIT_DISPLACEMENT, Profile, profile_of
from celltrain.membrane import meridian_membrane
from celltrain.meridian.geometry import largest_radius
from celltrain.meridian.rules import Rules, choose_rules
from celltrain.meridian.train import ALIKE, TrainFlow
from celltrain.parameters import Train
from celltrain.proximity.meridian import streamwise_gap

Unknowns = Float[np.ndarray, " unknown"]
#: Distance from the wall, and from the next cell along the tube.
Room = Float[np.ndarray, " 2"]


@dataclass(frozen=True)
class SteadyState:
    """Rates of change of one shape, their derivatives, and what is reported of it."""

    profile: Profile
    flow: TrainFlow
    missing_volume: float

    @cached_property
    def rates(self) -> Unknowns:
        """v in the frame of the cell's mean point, in U."""
        return self.flow.rates[1 : 2 * self.flow.degree - 1]

    @cached_property
    def jacobian(self) -> Float[np.ndarray, "unknown unknown"]:
        """J = dv/da."""
        inner = slice(1, 2 * self.flow.degree - 1)
        return self.flow.blocks(0, [ALIKE])[0].real[inner, inner]

    @cached_property
    def volume_gradient(self) -> Unknowns:
        """n = dV/da."""
        return self.flow.volume_gradient[1 : 2 * self.flow.degree - 1]

    @property
    def cell_velocity(self) -> float:
        """Velocity of the cell's mean point, in U."""
        return float(self.flow.rates[0]) / UNIT_DISPLACEMENT

    @cached_property
    def residual(self) -> float:
        """The largest |v - U_c e_z| at the targets, in U."""
        moving = self.flow.rates.copy()
        moving[0] = 0.0
        return float(np.linalg.norm(self.flow.at_targets(moving), axis=1).max())

    @cached_property
    def truncation_error(self) -> float:
        """The largest |u - U_c e_z| at the targets, before u is cut at the degree, in U."""
        upward = np.array([0.0, 0.0, self.cell_velocity])
        return float(np.linalg.norm(self.flow.velocity - upward, axis=1).max())

    @property
    def error(self) -> float:
        """What is to vanish: the residual, or the missing volume."""
        return max(self.residual, abs(self.missing_volume))

    def step(self, time_step: float) -> Unknowns:
        """Change of the unknowns by one step of implicit Euler; Newton's step if it is infinite."""
        right = np.append(self.rates, self.missing_volume)
        return np.linalg.solve(self.bordered(time_step), right)[:-1]

    def bordered(self, time_step: float = math.inf) -> Float[np.ndarray, "size size"]:
        """The matrix of the module."""
        size = len(self.rates)
        matrix = np.zeros((size + 1, size + 1))
        matrix[:size, :size] = np.eye(size) / time_step - self.jacobian
        matrix[:size, size] = matrix[size, :size] = self.volume_gradient
        return matrix


class SteadyProblem:
    """The steady equations of a train, whose degree is known.

    **Arguments:** `finer`: finer rules than those that a shape asks for, for estimates of error.

    **Raises:** `CaseError` if there is no shape of the cell's reduced volume.
    """

    def __init__(self, train: Train, *, finer: bool = False) -> None:
        self.train = train
        self.degree = train.degree
        self.membrane = meridian_membrane(train)
        self.rest = self.membrane.rest_profile
        self.target_volume = self.membrane.volume(self.rest)
        self._finer = finer

    def rules(self, profile: Profile) -> Rules:
        """The rules that a shape asks for."""
        rules = choose_rules(
            profile,
            period=self.train.period,
            radius=self.train.radius,
            targets=self.train.sizes.target_order,
        )
        return rules.finer() if self._finer else rules

    def fits(self, profile: Profile) -> bool:
        """Whether a cell of this shape is clear of the wall and of its neighbours."""
        # NaN does not fit.
        return bool((self.room(profile) > 0.0).all() and self.rules(profile).possible)

    def room(self, profile: Profile) -> Room:
        """Distance from the wall and from the next cell along the tube, r0."""
        beside = self.train.radius - largest_radius(profile)
        return np.array([beside, streamwise_gap(profile, self.train.period)])

    def flow(self, profile: Profile, rules: Rules | None = None) -> TrainFlow:
        """The flow about a shape; with its own rules unless others are given."""
        return TrainFlow(
            self.membrane,
            profile,
            radius=self.train.radius,
            period=self.train.period,
            rules=self.rules(profile) if rules is None else rules,
        )

    def state(self, profile: Profile, rules: Rules | None = None) -> SteadyState:
        """The state of a shape."""
        missing = self.target_volume - self.membrane.volume(profile)
        return SteadyState(profile, self.flow(profile, rules), missing)

    def moved(self, profile: Profile, change: Unknowns) -> Profile:
        """A shape with its unknowns changed."""
        return profile + change_of_profile(change)


def change_of_profile(change: Unknowns) -> Profile:
    """A change of the unknowns as one of the profile."""
    degree = len(change) // 2 + 1
    return np.stack([np.append(0.0, change[: degree - 1]), np.append(0.0, change[degree - 1 :])])


def unknowns_of(profile: Profile) -> Unknowns:
    """The unknowns of a shape."""
    return np.concatenate([profile[0, 1:], profile[1, 1:]])


def unknowns_of_shape(coefficients: Float[np.ndarray, "3 coefficient"]) -> Unknowns:
    """The same from the harmonic coefficients."""
    return unknowns_of(profile_of(coefficients))
