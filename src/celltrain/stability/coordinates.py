"""Coordinates of the disturbances that matter, in which a norm is the plain one.

Transient growth and resolvents need the dynamics on a space without the modes known to be neutral:

* disturbances of a cell's volume are left out: the volume cannot change, and its gradient n is a
  left null vector, so the disturbances with n^H d = 0 are invariant;
* the turn of a cell about its axis and the displacement of the whole train along the tube, r and
  t, are factored out: disturbances that differ by them are the same configuration, and the norm is
  the smallest among them, |d| = min |d + a r + b t|. All other rigid motions (tilts, displacements
  across the tube or of one cell against the next) are kept; they change the configuration.

With Q an orthonormal basis of the complement of (n, r, t), N = (r, t), y = Q^H d and G the norm's
Gram matrix, the dynamics is y' = Q^H A Q y (as in `block_spectrum`), the norm's matrix

    G_y = Q^H G Q - Q^H G N (N^H G N)^-1 N^H G Q = L^H L,

and x = L y has |x| = |d|. So exp(A t) has the norm of exp(B t), B = L (Q^H A Q) L^-1.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from jaxtyping import Complex, Float

from celltrain.parameters import CaseError
from celltrain.stability.neutral import NeutralSpace, neutral_space
from celltrain.stability.norms import Norm
from celltrain.stability.result import Stability


@dataclass(frozen=True)
class NormedBlock:
    """One block A_m(q) in coordinates x with the plain norm, rates in U/r0.

    `matrix` is B; `reduce` takes a disturbance in `azimuthal_basis(degree, m)` to x, `lift` takes x
    back, to the disturbance of smallest norm.
    """

    matrix: Complex[np.ndarray, "reduced reduced"]
    reduce: Float[np.ndarray, "reduced size"]
    lift: Float[np.ndarray, "size reduced"]

    @property
    def spectral_abscissa(self) -> float:
        """Largest growth rate of a mode, Eq. (14)."""
        return float(scipy.linalg.eigvals(self.matrix).real.max())

    @property
    def numerical_abscissa(self) -> float:
        """Largest growth rate at the first moment, Eq. (15)."""
        symmetric = 0.5 * (self.matrix + self.matrix.conj().T)
        return float(scipy.linalg.eigvalsh(symmetric)[-1])


def normed_block(
    block: Complex[np.ndarray, "size size"],
    gram: Float[np.ndarray, "size size"],
    neutral: NeutralSpace | None = None,
) -> NormedBlock:
    """A block in the coordinates of a norm, neutral modes removed (see the module).

    **Arguments:**

    - `block`: A_m(q), in U/r0.
    - `gram`: of the norm, positive definite.
    - `neutral`: known null vectors; none if not given.

    **Raises:** `CaseError` if the Gram matrix is not positive definite.
    """
    if neutral is None:
        neutral = NeutralSpace(np.zeros((len(block), 0)), (), None)
    known = [neutral.right]
    if neutral.volume is not None:
        known.append(neutral.volume[:, None])
    full = scipy.linalg.qr(np.concatenate(known, axis=1))[0] if neutral.count else np.eye(len(gram))
    rest, right = full[:, neutral.count :], neutral.right
    nearest = rest
    try:
        if right.shape[1]:
            # The member of smallest norm among those that differ by neutral displacements.
            nearest = rest - right @ scipy.linalg.solve(
                right.T @ gram @ right, right.T @ gram @ rest, assume_a="pos"
            )
        root = scipy.linalg.cholesky(nearest.T @ gram @ nearest)
    except np.linalg.LinAlgError:
        smallest = float(scipy.linalg.eigvalsh(gram)[0])
        raise CaseError(
            f"a norm whose smallest eigenvalue is {smallest:.3g} is not allowed: allowed are"
            " positive definite ones"
        ) from None
    inverse = scipy.linalg.solve_triangular(root, np.eye(len(root)))
    inner = rest.T @ block @ rest
    return NormedBlock((root @ inner @ inverse).astype(complex), root @ rest.T, nearest @ inverse)


def normed_blocks(result: Stability, norm: Norm) -> dict[tuple[int, int], NormedBlock]:
    """All blocks of a train in the coordinates of a norm, by (m, j), q = 2 pi j/N.

    **Raises:** `CaseError` if the norm is not positive definite.
    """
    grams = norm.grams(result.base.coefficients, result.azimuthal_numbers)
    return {
        (m, int(wave)): normed_block(block, grams[m], neutral_space(result.base, m, int(wave)))
        for m in result.azimuthal_numbers
        for wave, block in zip(result.wave_numbers, result.blocks[m], strict=True)
    }
