"""How the cells turn in a small disturbance of a steady train (Fig. 14)."""

from dataclasses import dataclass

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Complex, Float

from celltrain.diagnostics.rotation import cell_motion
from celltrain.diagnostics.spectrum import disturbance_amplitude
from celltrain.harmonics import azimuthal_basis
from celltrain.membrane.energy import Membrane
from celltrain.stability import Mode, Stability, TransientMode
from celltrain.train import train_membrane


@dataclass(frozen=True)
class ModeMotion:
    """Rotation rates of a disturbance for each unit of its amplitude.

    `tumbling` |omega| and `tank_treading` |Omega - omega|, Eqs. (17)-(21), in U/r0^2: root mean
    squares over cells and phases, over the norm of Eq. (8) for one cell, eps/sqrt(N).
    """

    tumbling: float
    tank_treading: float


def mode_motion(result: Stability, mode: Mode | TransientMode) -> ModeMotion:
    """Tumbling and tank-treading of a small disturbance at time 0, as in Fig. 14.

        tumbling = <|omega|^2>^(1/2)/(eps/sqrt(N)),
        tank-treading = <|Omega - omega|^2>^(1/2)/(eps/sqrt(N)),

    omega the rotation of the cell's axes, Eq. (19), Omega that of the membrane, Eq. (20).
    The steady train does not turn, so to first order in the disturbance d the rotations are those
    of the steady cell whose points move at the rates A d: exact, without a finite amplitude. By
    symmetry nothing turns for azimuthal numbers above 1; for 0 cells may turn about the tube's
    axis, their axis of symmetry, which counts as tumbling.
    """
    m, vector = mode.azimuthal_number, _vector(result, mode)
    degree = result.base.train.degree
    basis = azimuthal_basis(degree, m)
    rates = np.tensordot(result.blocks[m][mode.wave_number] @ vector, basis, axes=1)
    # A complex d stands for Re(d exp(i phase)) of each cell: both mean squares have a factor 1/2.
    norm = np.sqrt(
        disturbance_amplitude(np.tensordot(vector.real, basis, axes=1)[None]) ** 2
        + disturbance_amplitude(np.tensordot(vector.imag, basis, axes=1)[None]) ** 2
    )
    turning = _rotations(
        train_membrane(result.base.train),
        jnp.asarray(result.base.coefficients),
        jnp.stack([jnp.asarray(rates.real), jnp.asarray(rates.imag)]),
    )
    axes, membrane = (np.asarray(each) for each in turning)
    return ModeMotion(
        tumbling=float(np.linalg.norm(axes) / norm),
        tank_treading=float(np.linalg.norm(membrane - axes) / norm),
    )


@eqx.filter_jit
def _rotations(
    membrane: Membrane,
    shape: Float[Array, "3 coefficient"],
    rates: Float[Array, "part 3 coefficient"],
) -> tuple[Float[Array, "part 3"], Float[Array, "part 3"]]:
    motion = jax.vmap(lambda rate: cell_motion(membrane, shape, rate))(rates)
    return motion.rotation_rate, motion.membrane_rotation_rate


def _vector(result: Stability, mode: Mode | TransientMode) -> Complex[np.ndarray, " size"]:
    if isinstance(mode, TransientMode):
        return mode.vector
    return result.right_vectors[mode.azimuthal_number][mode.wave_number, :, mode.index]
