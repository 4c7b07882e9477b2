"""Strain energy of a cell by what resists: shear, dilatation, bending.

    W = W_s + W_d + W_b,                                       Eqs. (23), (24)

of Bryngelson & Freund (2018): the terms with the moduli Es, Ed and Eb. The sum is
`Membrane.energy`, the energy whose gradient is the force, with the membrane's own bending energy,
by default Eb/2 tr((kappa - kappa_ref)^2) for each area at rest. Eq. (23) writes that term with
differences of the principal curvatures. Bending moments have no energy: the paper's Eq. (2), taken
as its solver takes it, and Eq. (23) do not belong together.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from celltrain.diagnostics.quantities import ENERGY_PARTS
from celltrain.diagnostics.spectrum import disturbance_amplitude
from celltrain.harmonics import Shapes
from celltrain.harmonics.jax_shapes import JaxShape
from celltrain.laws import MomentBending
from celltrain.membrane import with_moduli
from celltrain.membrane.energy import Membrane
from celltrain.parameters import CaseError
from celltrain.programs import Program
from celltrain.steady import Base
from celltrain.train import train_membrane

#: The amplitude at which the paper computes energies, in r0.
PAPER_AMPLITUDE = 1e-3


def energy_parts(membrane: Membrane, shape: JaxShape) -> Float[Array, " part"]:
    """Energy of one cell by `ENERGY_PARTS`: shear, dilatation, bending; in mu U r0^2.

    The energy is linear in the moduli, so each part is the energy with the other moduli zero. A law
    without a dilatation modulus has no energy of dilatation. That of bending moments is not a
    number.
    """
    parts = [
        jnp.asarray(jnp.nan)
        if part == "bending" and isinstance(membrane.bending, MomentBending)
        else _part(membrane, modulus, shape)
        for part, modulus in ENERGY_PARTS.items()
    ]
    return jnp.stack(parts)


def _part(
    membrane: Membrane, modulus: str, shape: Float[Array, "3 coefficient"]
) -> Float[Array, ""]:
    alone = _with_only(membrane, modulus)
    if isinstance(membrane.bending, MomentBending):
        return alone.in_plane_energy(shape)
    return alone.energy(shape)


def _with_only(membrane: Membrane, modulus: str) -> Membrane:
    """The membrane without its moduli but one."""
    none = {name: jnp.zeros(()) for name in ENERGY_PARTS.values() if name != modulus}
    return eqx.tree_at(
        lambda each: (each.law, each.bending),
        membrane,
        (with_moduli(membrane.law, none), with_moduli(membrane.bending, none)),
    )


def perturbation_energy(
    base: Base,
    disturbance: Shapes,
    amplitude: float = PAPER_AMPLITUDE,
) -> Float[np.ndarray, " part"]:
    """Strain energy of a disturbance by shear, dilatation and bending, Eq. (24) and Table I.

        W = (r0/(eps N)) sum_i (W_i - W_i^B),

    in mu U r0^2, of the steady train plus the disturbance scaled to the amplitude eps. To first
    order the cells' energies add up to nothing unless the disturbance is axisymmetric and alike in
    all cells; then W depends on its sign. Otherwise W is proportional to eps.

    Table I is read best as the sum over the N cells in mu U* r0^2, U* = U/10 as for the rates (see
    `parameters.units` and the validation page on mechanisms): W times 10 N.

    **Arguments:**

    - `disturbance`: of every cell, as from `Stability.shape` or `Stability.transient_shape`.
    - `amplitude`: eps in the norm of Eq. (8), in r0.

    **Raises:** `CaseError` for an amplitude that is not positive, a disturbance that is zero, or
    cells with bending moments, which have no energy.
    """
    bending = base.train.cell.bending
    if bending.endswith("moments"):
        raise CaseError(
            f"bending = {bending!r} has no energy: not allowed for strain energies (Eqs. 23, 24);"
            " allowed there: bending = 'elastic', 'helfrich'"
        )
    size = disturbance_amplitude(disturbance)
    if not amplitude > 0.0 or not size > 0.0:
        raise CaseError(
            f"amplitude = {amplitude:g} of a disturbance of norm {size:g} is not allowed: allowed"
            " are both > 0"
        )
    shapes = base.coefficients + amplitude / size * disturbance
    parts = _energies(train_membrane(base.train), jnp.asarray([base.coefficients, *shapes]))
    return np.asarray(jnp.mean(parts[1:] - parts[0], axis=0)) / amplitude


@Program
def _energies(
    membrane: Membrane, shapes: Float[Array, "shape 3 coefficient"]
) -> Float[Array, "shape part"]:
    return jax.vmap(lambda shape: energy_parts(membrane, shape))(shapes)
