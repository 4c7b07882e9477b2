"""What the motions of a steady train's cells give each other.

The part of K (see `interior`) that does not come from a cell's own surface in free space, of the
steady train: a matrix for each azimuthal number and phase, by the double layer on the meridian
(`meridian.double_layer`). It is close to that of the same train when it is disturbed, and its
application takes a hundredth of the time.
"""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Complex, Float

from celltrain.harmonics import azimuthal_basis, turned_family
from celltrain.harmonics.jax_shapes import JaxShapes
from celltrain.membrane import place_cells
from celltrain.runtime import constant
from celltrain.stability.linearise import LinearDynamics, smallest
from celltrain.steady import Base

# Root mean square displacement (r0) from the steady train beyond which it is of no use.
FARTHEST = 0.2


class Coupling(eqx.Module):
    """The part of K, and the shapes of the steady train.

    `families`: disturbances of one cell by azimuthal number, those with z ~ cos(m phi) and with
    z ~ sin(m phi) each, orthonormal; `blocks`: in these, for waves exp(i q p) of the cells.
    """

    families: Float[Array, "family member value"]
    blocks: Complex[Array, "family wave member member"]
    steady: JaxShapes

    def serves(self, shapes: JaxShapes) -> Bool[Array, ""]:
        """Whether shapes are close enough to those of the steady train for it to be of use."""
        square = jnp.sum((shapes - self.steady) ** 2) / (4.0 * jnp.pi * shapes.shape[0])
        return square < FARTHEST**2

    def __call__(self, motions: JaxShapes) -> JaxShapes:
        """The flow that motions of the cells give through other cells, images and the wall."""
        cells = motions.shape[0]
        members = jnp.einsum("fmv,cv->cfm", self.families, motions.reshape(cells, -1))
        waves = jnp.einsum("fwmn,wfn->wfm", self.blocks, jnp.fft.rfft(members, axis=0))
        flow = jnp.fft.irfft(waves, n=cells, axis=0)
        return jnp.einsum("fmv,cfm->cv", self.families, flow).reshape(motions.shape)


def train_coupling(base: Base) -> Coupling:
    """That of all cells of a steady train whose viscosity differs from the plasma's."""
    train = base.train
    phases = 2.0 * np.pi * np.arange(train.cells // 2 + 1) / train.cells
    dynamics = LinearDynamics(
        base, largest_azimuthal_number=train.degree, smallest_phase=smallest(phases)
    )
    families, blocks = [], []
    for m in range(train.degree + 1):
        basis = azimuthal_basis(train.degree, m)
        if basis.size:
            block = dynamics.coupling(m, phases)
            for family in (basis,) if m == 0 else (basis, turned_family(basis, m)):
                families.append(family.reshape(len(family), -1))
                blocks.append(block)
    size = max(map(len, families))
    filled = np.zeros((len(families), size, families[0].shape[1]))
    by_wave = np.zeros((len(families), len(phases), size, size), dtype=complex)
    for place, (family, block) in enumerate(zip(families, blocks, strict=True)):
        filled[place, : len(family)] = family
        by_wave[place, :, : len(family), : len(family)] = block
    steady = place_cells(base.coefficients, train, train.cells)
    return Coupling(constant(filled), constant(by_wave), constant(steady))
