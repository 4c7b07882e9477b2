"""How growth rates change with the parameters of a train, exactly.

For a simple eigenvalue of a block, w^H A = lambda w^H, A v = lambda v, w^H v = 1, and a parameter p

    d lambda/dp = w^H (dA/dp) v,   dA/dp = A_p + A_s [ds/dp],                                (a)

with ds/dp the change of the steady train (see `base_sensitivities`). Both parts are one derivative
of A(q; s, p) along (ds/dp, 1), at fixed grids and rules and fixed q (radians per cell): an
extrapolated central difference of the assembled block, good to nine digits (see `steady.varied`).
With a viscosity ratio lam other than 1, A = B^-1 A1 and B = (1 + lam)/2 - (1 - lam) K (see
`linearise`), it is

    d lambda/dp = w^H B^-1 (dA1/dp - lambda dB/dp) v.

No train is computed anew. One at other parameters may choose other grids and rules, within their
tolerance, as a difference quotient over a small step will show.

An eigenvalue that several modes share by symmetry (the mirror image, -q) is simple in its block.
Close to a multiple one, where l^H r of unit vectors vanishes, the derivative becomes infinite: see
`condition_number`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import numpy as np
from jaxtyping import Complex

from celltrain.harmonics import Profile, profile_of
from celltrain.meridian.double_layer import DoubleLayer
from celltrain.meridian.train import SMALLEST_PHASE, TrainFlow
from celltrain.parameters import CaseError
from celltrain.quantities import Quantity, Record, quantity
from celltrain.stability.adjoint import mode_vectors
from celltrain.stability.infinite import WaveMode
from celltrain.stability.result import Mode, Stability
from celltrain.steady.base import Base
from celltrain.steady.parameters import check_parameters, parameter_value, parameters_of
from celltrain.steady.problem import SteadyProblem
from celltrain.steady.sensitivity import BaseSensitivity, base_sensitivities
from celltrain.steady.varied import VariedTrain

Vector = Complex[np.ndarray, " size"]


@dataclass(frozen=True, eq=False)
class ParameterSensitivity(Record):
    """Derivatives by one parameter: of an eigenvalue (U/r0) and of the steady train."""

    parameter: Annotated[str, Quantity("p", "1", "name of the parameter")]
    value: Annotated[float, Quantity("p", "", "value of the parameter, in r0, mu and U")]
    growth_rate: Annotated[
        float,
        Quantity(
            r"d\alpha/dp",
            "U/r0 per parameter",
            "derivative of the growth rate",
            equation=r"d\lambda/dp = w^H (dA/dp) v",
        ),
    ]
    frequency: Annotated[
        float, Quantity(r"d\omega/dp", "U/r0 per parameter", "derivative of the frequency")
    ]
    base: BaseSensitivity

    @property
    @quantity(
        Quantity(r"p\,d\alpha/dp", "U/r0", "change for each relative change of the parameter")
    )
    def relative(self) -> float:
        """d(growth rate)/d(log p), in U/r0: the change by one per cent of p is 0.01 of it."""
        return self.value * self.growth_rate


@dataclass(frozen=True, eq=False)
class ParameterSensitivities(Record):
    """Derivatives of one eigenvalue of the linear dynamics by the parameters of its train.

    `mode` has the eigenvalue itself, with q in radians per cell; `entries` are keyed by parameter.
    """

    base: Base
    mode: WaveMode
    entries: dict[str, ParameterSensitivity]


def parameter_sensitivities(
    result: Stability, mode: Mode | None = None, *, parameters: Sequence[str] | None = None
) -> ParameterSensitivities:
    """Derivatives of a growth rate and frequency by a train's parameters.

        d lambda/dp = w^H (A_p + A_s [ds/dp]) v,     Eq. (a) of the module.

    **Arguments:**

    - `result`: the linear dynamics of the train.
    - `mode`: one of its modes; the leading one if not given.
    - `parameters`: names among `PARAMETERS`, all that the train has if not given. Lengths in r0,
      moduli in mu U.

    **Raises:** `CaseError` for a neutral mode or a parameter that is not allowed.
    """
    mode = result.leading if mode is None else mode
    if mode.neutral:
        raise CaseError(f"mode = {mode.neutral_kind} is not allowed: it is neutral")
    left, right = mode_vectors(result, mode)
    q = 2.0 * np.pi * mode.wave_number / result.base.train.cells
    wave = WaveMode(mode.growth_rate, mode.frequency, mode.azimuthal_number, q, right, left)
    return wave_sensitivities(result.base, wave, parameters=parameters)


def wave_sensitivities(
    base: Base, mode: WaveMode, *, parameters: Sequence[str] | None = None
) -> ParameterSensitivities:
    """The same for a mode of an infinite train with any phase q, which is held.

    **Raises:** `CaseError` for a parameter that is not allowed.
    """
    train = base.train
    names = parameters_of(train) if parameters is None else tuple(parameters)
    check_parameters(names, train)
    of_base = base_sensitivities(base, names)
    wave = _Wave(base, mode)
    entries = {}
    for name in names:
        slope = wave.slope(of_base[name])
        value = parameter_value(train, name)
        entries[name] = ParameterSensitivity(
            name, value, float(slope.real), float(slope.imag), of_base[name]
        )
    return ParameterSensitivities(base, mode, entries)


class _Wave:
    """The equation of one wave, (A1 - lambda B) v = 0, at other parameters."""

    def __init__(self, base: Base, mode: WaveMode) -> None:
        self._problem, self._profile, self._mode = SteadyProblem(base.train), base.profile, mode
        self._ratio = base.train.flow.viscosity_ratio
        self._value = complex(mode.growth_rate, mode.frequency)

    def slope(self, of_base: BaseSensitivity) -> complex:
        """d lambda/dp, from the change of the steady train."""
        if of_base.parameter == "viscosity_ratio":
            # Neither the train nor A1 depends on it, and dB/dlam = 1/2 + K.
            right = self._mode.right
            by_ratio = 0.5 * right + self._layer @ right
            return complex(-self._value * (self._left.conj() @ by_ratio))
        varied = VariedTrain(self._problem, self._profile, of_base.parameter)
        along = profile_of(of_base.coefficients)

        def left_over(change: float) -> Vector:
            flow = self._flow(varied, change, self._profile + change * along)
            return self._left_over(flow)

        return complex(self._left.conj() @ varied.derivative(left_over))

    def _left_over(self, flow: TrainFlow) -> Vector:
        """(A1 - lambda B) v."""
        m, phases, right = self._mode.azimuthal_number, [self._mode.phase], self._mode.right
        rates: Vector = flow.blocks(m, phases)[0] @ right
        if self._ratio == 1.0:
            # B = 1 whatever the parameter is.
            return rates
        equation = DoubleLayer(flow).equation(m, phases, self._ratio)[0]
        return rates - self._value * (equation @ right)

    def _flow(self, varied: VariedTrain, change: float, profile: Profile) -> TrainFlow:
        phase = self._mode.phase
        return varied.flow(
            change,
            profile,
            largest_azimuthal_number=self._mode.azimuthal_number,
            smallest_phase=min(phase, SMALLEST_PHASE) if phase > 0.0 else SMALLEST_PHASE,
        )

    @cached_property
    def _layer(self) -> Complex[np.ndarray, "size size"]:
        """K of the train itself."""
        still = VariedTrain(self._problem, self._profile, "viscosity_ratio")
        flow = self._flow(still, 0.0, self._profile)
        return DoubleLayer(flow).blocks(self._mode.azimuthal_number, [self._mode.phase])[0]

    @cached_property
    def _left(self) -> Vector:
        """B^-H w."""
        left, ratio = self._mode.left, self._ratio
        if ratio == 1.0:
            return left
        equation = 0.5 * (1.0 + ratio) * np.eye(len(left)) - (1.0 - ratio) * self._layer
        return np.linalg.solve(equation.conj().T, left)
