"""What the motions of a steady train's cells give each other.

The part of K (see `interior`) that does not come from a cell's own surface in free space, of the
steady train: a matrix for each azimuthal number and phase, by the double layer on the meridian
(`meridian.double_layer`). It is close to that of the same train when it is disturbed, and its
application takes little time.
"""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Complex, Float

from celltrain.harmonics import both_families
from celltrain.harmonics.jax_shapes import JaxShapes
from celltrain.membrane import place_cells
from celltrain.parameters import CaseError
from celltrain.runtime import constant
from celltrain.stability.linearise import LinearDynamics, smallest
from celltrain.steady import Base

# Displacement from the steady train beyond which it is of no use: r0, root mean square over a cell.
FARTHEST = 0.2


class Coupling(eqx.Module):
    """The part of K, and the shapes of the steady train.

    `families`: disturbances of one cell by azimuthal number, those with z ~ cos(m phi) and those
    with z ~ sin(m phi), orthonormal; `blocks`: in either of these, for waves exp(i q p) of the
    cells.
    """

    families: Float[Array, "number 2 member value"]
    blocks: Complex[Array, "number wave member member"]
    steady: JaxShapes

    def serves(self, shapes: JaxShapes) -> Bool[Array, ""]:
        """Whether all cells are close enough to those of the steady train for it to be of use."""
        if shapes.shape != self.steady.shape:
            raise ValueError(f"shapes {shapes.shape} of a train with {self.steady.shape}")
        moved = shapes - self.steady
        # The whole train may be anywhere along the tube.
        moved = moved.at[:, 2, 0].add(-jnp.mean(moved[:, 2, 0]))
        return jnp.max(jnp.sum(moved**2, axis=(1, 2))) < 4.0 * jnp.pi * FARTHEST**2

    def __call__(self, motions: JaxShapes) -> JaxShapes:
        """The flow that motions of the cells give through other cells, images and the wall."""
        cells = motions.shape[0]
        members = jnp.einsum("asmv,cv->casm", self.families, motions.reshape(cells, -1))
        waves = jnp.einsum("awmn,wasn->wasm", self.blocks, jnp.fft.rfft(members, axis=0))
        flow = jnp.fft.irfft(waves, n=cells, axis=0)
        return jnp.einsum("asmv,casm->cv", self.families, flow).reshape(motions.shape)


def train_coupling(base: Base) -> Coupling:
    """That of all cells of a steady train whose viscosity differs from the plasma's.

    **Raises:** `CaseError` for one whose viscosity does not.
    """
    train = base.train
    if train.flow.viscosity_ratio == 1.0:
        raise CaseError("viscosity_ratio = 1 is not allowed here: such cells need no coupling")
    phases = 2.0 * np.pi * np.arange(train.cells // 2 + 1) / train.cells
    dynamics = LinearDynamics(
        base, largest_azimuthal_number=train.degree, smallest_phase=smallest(phases)
    )
    members = [both_families(train.degree, m) for m in range(train.degree + 1)]
    size = max(len(both[0]) for both in members)
    # Filled up with zeros: there is no second family for m = 0, and there are fewer for larger m.
    families = np.zeros((len(members), 2, size, 3 * train.degree**2))
    blocks = np.zeros((len(members), len(phases), size, size), dtype=complex)
    for m, both in enumerate(members):
        count = len(both[0])
        for family, each in enumerate(both):
            families[m, family, :count] = each.reshape(count, -1)
        blocks[m, :, :count, :count] = dynamics.coupling(m, phases)
    steady = place_cells(base.coefficients, train, train.cells)
    return Coupling(constant(families), constant(blocks), constant(steady))
