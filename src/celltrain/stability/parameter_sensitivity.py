"""How growth rates change with the parameters of a train, exactly.

For a simple eigenvalue of a block, w^H A = lambda w^H, A v = lambda v, w^H v = 1, and a parameter p

    d lambda/dp = w^H (dA/dp) v,   dA/dp = A_p + A_s [ds/dp],                                (a)

with ds/dp the change of the steady train (see `base_sensitivities`). Both parts are one derivative
of A(q; s, p) v along (ds/dp, 1), taken by forward differentiation of the discrete dynamics at fixed
grids and rules, at fixed q (radians per cell). With a viscosity ratio lam other than 1, A = B^-1 A1
and B = (1 + lam)/2 - (1 - lam) K (see `linearise`), it is

    d lambda/dp = w^H B^-1 (dA1/dp - lambda dB/dp) v.

So nothing is differenced, and these are derivatives of what the discrete equations give to about
the accuracy of their solution. A train computed anew at other parameters may choose other grids
and rules, within its `tolerance`, as a difference quotient will show.

An eigenvalue that several modes share by symmetry (the mirror image, -q) is simple in its block.
Close to a multiple one, where l^H r of unit vectors vanishes, the derivative becomes infinite: see
`condition_number`.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr
from jaxtyping import Array, Complex, Float

from celltrain.harmonics import azimuthal_basis
from celltrain.parameters import CaseError
from celltrain.stability.adjoint import mode_vectors
from celltrain.stability.infinite import WaveMode
from celltrain.stability.linearise import BATCH, interior_action, linear_action
from celltrain.stability.result import Mode, Stability
from celltrain.steady import Base, BaseSensitivity, base_sensitivities
from celltrain.train import (
    Variation,
    check_parameters,
    clearance,
    close_distance,
    parameter_value,
    parameters_of,
    train_operator,
    variation,
)


@dataclass(frozen=True)
class ParameterSensitivity:
    """Derivatives by one parameter: of an eigenvalue (U/r0) and of the steady train."""

    parameter: str
    value: float
    growth_rate: float
    frequency: float
    base: BaseSensitivity

    @property
    def relative(self) -> float:
        """d(growth rate)/d(log p), in U/r0: the change by one per cent of p is 0.01 of it."""
        return self.value * self.growth_rate


@dataclass(frozen=True)
class ParameterSensitivities:
    """Derivatives of one eigenvalue of the linear dynamics by the parameters of its train.

    `mode` has the eigenvalue itself, with q in radians per cell; `entries` are keyed by parameter.
    """

    base: Base
    mode: WaveMode
    entries: dict[str, ParameterSensitivity]

    def to_dataset(self) -> xr.Dataset:
        """All derivatives as a data set, ready for netCDF; parameters in r0, mu U and mu U r0^2."""
        entries = self.entries.values()

        def column(values: list[float], unit: str, name: str) -> xr.Variable:
            return xr.Variable("parameter", values, {"long_name": name, "units": unit})

        of_base = [entry.base for entry in entries]
        notes = {"title": "sensitivities of a mode and its train", "origin": self.base.origin}
        return xr.Dataset(
            {
                "value": column([e.value for e in entries], "", "value of the parameter"),
                "growth_rate": column(
                    [e.growth_rate for e in entries], "U/r0 per parameter", "d(growth rate)/dp"
                ),
                "frequency": column(
                    [e.frequency for e in entries], "U/r0 per parameter", "d(frequency)/dp"
                ),
                "cell_velocity": column(
                    [b.cell_velocity for b in of_base], "U per parameter", "d(cell velocity)/dp"
                ),
                "effective_viscosity": column(
                    [b.effective_viscosity for b in of_base],
                    "mu per parameter",
                    "d(effective viscosity)/dp",
                ),
            },
            coords={"parameter": list(self.entries)},
            attrs=notes
            | {
                "case": self.base.train.to_toml(),
                "mode_growth_rate": self.mode.growth_rate,
                "mode_frequency": self.mode.frequency,
                "mode_azimuthal_number": self.mode.azimuthal_number,
                "mode_phase": self.mode.phase,
            },
        )


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
    changed = jnp.asarray(np.stack([of_base[name].coefficients for name in names]))
    equal, ratio = train.changed(viscosity_ratio=1.0), train.flow.viscosity_ratio
    close = clearance(base.coefficients, train.period, train.radius) < close_distance(train)
    still = variation(train_operator(equal, close=close), train, names)
    moving = train_operator(equal, close=close, phase=mode.phase)
    wave = variation(moving, train, names)
    shape = jnp.asarray(base.coefficients)
    basis = azimuthal_basis(train.degree, mode.azimuthal_number)
    directions = np.einsum("pu,uik->pik", [mode.right.real, mode.right.imag], basis)
    value = complex(mode.growth_rate, mode.frequency)

    def in_basis(answers: Array) -> Complex[np.ndarray, "... size"]:
        """What happens to the mode, from what happens to its real and its imaginary part."""
        parts = np.einsum("...pik,uik->...pu", np.asarray(answers), basis)
        return np.asarray(parts[..., 0, :] + 1j * parts[..., 1, :])

    unequal = ratio != 1.0
    moved = _changes(still, wave, names, unequal, shape, jnp.asarray(directions), changed)
    moments = in_basis(moved[0])
    left = mode.left
    if unequal:
        # dB/dp = -(1 - lam) dK/dp.
        moments = moments + value * (1.0 - ratio) * in_basis(moved[1])
        flow = _interior_block(wave, shape, basis)
        equation = 0.5 * (1.0 + ratio) * np.eye(len(basis)) - (1.0 - ratio) * flow
        left = np.linalg.solve(equation.conj().T, left)
    slopes = moments @ left.conj()
    if "viscosity_ratio" in names:
        # dB/dlam = 1/2 + K; neither the train nor A1 depends on it.
        flow_of_mode = in_basis(interior_action(wave.operator, shape, jnp.asarray(directions)))
        by_ratio = -value * (left.conj() @ (0.5 * mode.right + flow_of_mode))
        slopes[names.index("viscosity_ratio")] = by_ratio
    return ParameterSensitivities(
        base,
        mode,
        {
            name: ParameterSensitivity(
                name,
                parameter_value(train, name),
                float(slope.real),
                float(slope.imag),
                of_base[name],
            )
            for name, slope in zip(names, slopes, strict=True)
        },
    )


@eqx.filter_jit
def _changes(
    still: Variation,
    wave: Variation,
    names: tuple[str, ...],
    unequal: bool,
    shape: Float[Array, "3 coefficient"],
    directions: Float[Array, "direction 3 coefficient"],
    changed: Float[Array, "parameter 3 coefficient"],
) -> tuple[Complex[Array, "parameter direction 3 coefficient"], ...]:
    """Change of A1 d, and with `unequal` viscosities of K d, along each parameter and its shape."""

    def observed(values: Array, shape: Array) -> tuple[Array, ...]:
        chosen = dict(zip(names, values, strict=True))
        moving = wave.at(chosen)
        answers = linear_action(still.at(chosen), moving, shape, directions)
        if not unequal:
            return (answers,)
        return answers, interior_action(moving, shape, directions)

    start = jnp.stack([still.start[name] for name in names])

    def change(pair: tuple[Array, Array]) -> tuple[Array, ...]:
        found: tuple[Array, ...] = jax.jvp(observed, (start, shape), pair)[1]
        return found

    return jax.lax.map(change, (jnp.eye(len(names)), changed))


def _interior_block(
    wave: Variation,
    shape: Float[Array, "3 coefficient"],
    basis: Float[np.ndarray, "size 3 coefficient"],
) -> Complex[np.ndarray, "size size"]:
    """K_m(q) in the basis of an azimuthal number."""
    # Whole batches only: a remainder would be compiled as a second program.
    padded = np.pad(basis, ((0, -len(basis) % BATCH), (0, 0), (0, 0)))
    answers = np.asarray(interior_action(wave.operator, shape, jnp.asarray(padded)))
    return np.einsum("vik,uik->uv", answers[: len(basis)], basis)
