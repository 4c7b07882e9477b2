"""Eigenvalues of the linear dynamics, with the modes known to be neutral deflated (see `neutral`).

Left to the eigenvalue solver, volume and displacement form a Jordan block, whose double zero splits
into +-sqrt(error): 2e-4 where the matrix itself is good to 1e-8. Instead, the deflated dynamics is
restricted to disturbances without volume (an invariant subspace, since n^H A' = 0) modulo r and t
(A' r = A' t = 0): with Q an orthonormal basis of the complement of (n, r, t), the other eigenvalues
are those of Q^H A Q. Abscissas and their meaning: Trefethen & Embree (2005).
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from jaxtyping import Complex, Float

from celltrain.stability.neutral import NeutralSpace, deflated


@dataclass(frozen=True)
class BlockSpectrum:
    """Eigenvalues of one block, by falling growth rate, and vectors with left^H right = 1.

    `kinds` names the neutral ones ("rotation", "translation", "volume") and is "" for the others;
    a neutral mode's eigenvalue is the Rayleigh quotient of its known vector in the deflated block,
    zero to rounding. The left null vector of the displacement and the right one of the volume are
    generalised ones. All are those of the deflated block.
    """

    eigenvalues: Complex[np.ndarray, " size"]
    right: Complex[np.ndarray, "size size"]
    left: Complex[np.ndarray, "size size"]
    kinds: tuple[str, ...]


def block_spectrum(block: Complex[np.ndarray, "size size"], neutral: NeutralSpace) -> BlockSpectrum:
    """Spectrum of A_m(q) with the neutral modes deflated and set apart."""
    block, volume = deflated(block, neutral), neutral.volume
    known = [neutral.right] if volume is None else [neutral.right, volume[:, None]]
    removed = np.concatenate(known, axis=1)
    full = scipy.linalg.qr(removed)[0] if neutral.count else np.eye(len(block))
    rest = full[:, neutral.count :]
    inner = rest.T @ block @ rest
    values, left, right = scipy.linalg.eig(_plain(inner), left=True, right=True)
    # Back to all disturbances: a part along r and t on the right, along n on the left.
    full_right = rest @ right + neutral.right @ (neutral.right.T @ block @ rest @ right / values)
    full_left = rest @ left
    if volume is not None:
        along = (left.conj().T @ rest.T @ block @ volume) / values
        full_left = full_left + np.outer(volume, along.conj())
    kinds = [""] * len(values)
    for kind, vector in zip(neutral.kinds, neutral.right.T, strict=True):
        partner = vector - rest @ np.linalg.solve(inner.conj().T, rest.T @ block.conj().T @ vector)
        values = np.append(values, vector @ block @ vector)
        full_right = np.column_stack([full_right, vector])
        full_left = np.column_stack([full_left, partner])
        kinds.append(kind)
    if volume is not None:
        inflated = volume - rest @ np.linalg.solve(inner, rest.T @ block @ volume)
        values = np.append(values, volume @ block @ volume)
        full_right = np.column_stack([full_right, inflated])
        full_left = np.column_stack([full_left, volume])
        kinds.append("volume")
    full_right = full_right / np.linalg.norm(full_right, axis=0)
    overlap = np.sum(full_left.conj() * full_right, axis=0)
    full_left = full_left / overlap.conj()
    order = np.argsort(-values.real, kind="stable")
    return BlockSpectrum(
        values[order],
        full_right[:, order].astype(complex),
        full_left[:, order].astype(complex),
        tuple(kinds[i] for i in order),
    )


def growing_eigenvalues(
    block: Complex[np.ndarray, "size size"], neutral: NeutralSpace
) -> Complex[np.ndarray, " rest"]:
    """The eigenvalues that are not neutral, by falling growth rate, without vectors."""
    block = deflated(block, neutral)
    known = [neutral.right] if neutral.volume is None else [neutral.right, neutral.volume[:, None]]
    if neutral.count:
        rest = scipy.linalg.qr(np.concatenate(known, axis=1))[0][:, neutral.count :]
        block = rest.T @ block @ rest
    values = np.asarray(scipy.linalg.eigvals(_plain(block)), dtype=complex)
    return values[np.argsort(-values.real, kind="stable")]


def _plain(block: Complex[np.ndarray, "size size"]) -> np.ndarray:
    """A block without imaginary part as a real matrix: a quarter of the work."""
    return block.real if not block.imag.any() else block


def numerical_abscissa(
    block: Complex[np.ndarray, "size size"], gram: Float[np.ndarray, "size size"]
) -> tuple[float, Complex[np.ndarray, " size"]]:
    """Largest initial growth rate of any disturbance, Eq. (15), and that disturbance.

    eta = max d^H (G A + A^H G) d/(2 d^H G d), G the Gram matrix of the norm.
    """
    weighted = gram @ block
    values, vectors = scipy.linalg.eigh(0.5 * (weighted + weighted.conj().T), gram)
    return float(values[-1]), vectors[:, -1].astype(complex)
