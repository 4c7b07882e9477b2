"""The linear dynamics of a train as the linear part of its motion, wherever its cells have turned.

Near a steady train shapes move by ds/dt = f(s) with f(s + d) = f(s) + L d and little else, L d =
R A R^T d: A of the linear dynamics about the steady train (`stability.linear_blocks`), and R the
rotation of each cell from its orientation in that train. Membranes are elastic and cells turn as a
whole, so that what is fast in f stays in L wherever they are.

Exponential methods take the functions

    phi_1(z) = (exp z - 1)/z,   phi_2(z) = (phi_1(z) - 1)/z,   phi_3(z) = (phi_2(z) - 1/2)/z

of z = h L, here by their Taylor series of a small z and

    phi_1(2 z) = phi_1(z) (exp z + 1)/2,   phi_2(2 z) = (phi_1(z)^2 + 2 phi_2(z))/4,
    phi_3(2 z) = (phi_1(z) phi_2(z) + phi_2(z) + 2 phi_3(z))/8,

(Skaflestad & Wright 2009) on each block A_m(q) alone.
"""

import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np
from jaxtyping import Complex, Float

from celltrain.harmonics import Shapes, both_families
from celltrain.membrane import place_cells
from celltrain.stability.linearise import linear_blocks
from celltrain.steady import Base

# Norm of z up to which the Taylor series is taken, and its terms: the first one left out is below
# rounding.
SMALL, TERMS = 0.5, 14
# Steps are 2^(k/2), so that functions of few steps are needed.
PER_OCTAVE = 2
# Steps whose functions are kept.
KEPT = 3

Blocks = Complex[np.ndarray, "wave _ _"]
Turns = Float[np.ndarray, "cell 3 3"]


class LinearPart:
    """L of a steady train; made when it is first needed."""

    def __init__(self, base: Base) -> None:
        self._base = base
        self._functions: dict[int, tuple[list[Blocks], ...]] = {}

    def turns(self, shapes: Shapes) -> Turns:
        """The rotation that brings each cell of the steady train nearest to how it is."""
        covariance = np.einsum("cik,cjk->cij", shapes[..., 1:], self._steady[..., 1:])
        left, _, right = np.linalg.svd(covariance)
        left[..., -1] *= np.linalg.det(left @ right)[:, None]
        return left @ right

    def applied(self, turns: Turns, change: Shapes) -> Shapes:
        """L d."""
        return self._by_blocks(self._blocks, turns, change)

    def phi_1(self, level: int, turns: Turns, change: Shapes) -> Shapes:
        """The first function of h L, of the step of a level (see `step_of`), times d."""
        return self._by_blocks(self._of_level(level)[0], turns, change)

    def phi_2(self, level: int, turns: Turns, change: Shapes) -> Shapes:
        """The second function of h L, of the step of a level (see `step_of`), times d."""
        return self._by_blocks(self._of_level(level)[1], turns, change)

    def phi_3(self, level: int, turns: Turns, change: Shapes) -> Shapes:
        """The third function of h L, of the step of a level (see `step_of`), times d."""
        return self._by_blocks(self._of_level(level)[2], turns, change)

    def within(
        self, level: int, turns: Turns, rates: Shapes, change: Shapes, part: float
    ) -> Shapes:
        """The change of shapes after a part of the step h of a level with the given whole change.

        With tau = part h it is tau phi_1(tau L) f + part^2 phi_2(tau L) phi_2(h L)^-1 c, c being
        what the whole change has beside h phi_1(h L) f, as if the rest of the rates grew evenly in
        time.
        """
        step = step_of(level)
        whole = self._of_level(level)[1]
        first, second, _ = self._functions_of(part * step)
        begun = part * step * self._by_blocks(first, turns, rates)
        ratios = [np.linalg.solve(*each) for each in zip(whole, second, strict=True)]
        beside = change - step * self.phi_1(level, turns, rates)
        return begun + part**2 * self._by_blocks(ratios, turns, beside)

    def _by_blocks(self, blocks: Sequence[Blocks], turns: Turns, change: Shapes) -> Shapes:
        cells = len(change)
        body = np.einsum("cji,cjk->cik", turns, change).reshape(cells, -1)
        waves = np.fft.rfft(body @ self._families.T, axis=0)
        moved = np.empty_like(waves)
        first = 0
        for block, copies in zip(blocks, self._copies, strict=True):
            size = block.shape[-1]
            for _ in range(copies):
                part = slice(first, first + size)
                moved[:, part] = np.einsum("juv,jv->ju", block, waves[:, part])
                first += size
        back = np.fft.irfft(moved, n=cells, axis=0) @ self._families
        return np.einsum("cij,cjk->cik", turns, back.reshape(change.shape))

    @cached_property
    def _steady(self) -> Shapes:
        return place_cells(self._base.coefficients, self._base.train, self._base.train.cells)

    @cached_property
    def _numbers(self) -> range:
        """Azimuthal numbers of all disturbances."""
        return range(self._base.train.degree + 1)

    @cached_property
    def _families(self) -> Float[np.ndarray, "member value"]:
        """All disturbances of one cell, ordered by azimuthal number; together orthonormal.

        Of m > 0 those with z ~ cos(m phi), and after them those with z ~ sin(m phi), whose blocks
        are the same.
        """
        degree = self._base.train.degree
        members = np.concatenate([each for m in self._numbers for each in both_families(degree, m)])
        return members.reshape(len(members), -1)

    @cached_property
    def _copies(self) -> list[int]:
        return [1 if m == 0 else 2 for m in self._numbers]

    @cached_property
    def _blocks(self) -> list[Blocks]:
        cells = self._base.train.cells
        phases = 2.0 * np.pi * np.arange(cells // 2 + 1) / cells
        found = linear_blocks(self._base, phases, self._numbers)
        return [found[m] for m in self._numbers]

    def _of_level(self, level: int) -> tuple[list[Blocks], ...]:
        if level not in self._functions:
            while len(self._functions) >= KEPT:
                del self._functions[next(iter(self._functions))]
            self._functions[level] = self._functions_of(step_of(level))
        return self._functions[level]

    def _functions_of(self, step: float) -> tuple[list[Blocks], ...]:
        of_blocks = [_functions(step * each) for each in self._blocks]
        return tuple(list(each) for each in zip(*of_blocks, strict=True))


def step_of(level: int) -> float:
    """The step of a level, 2^(level/2) r0/U."""
    return float(2.0 ** (level / PER_OCTAVE))


def level_of(step: float) -> int:
    """The level of the longest step up to this one (to rounding)."""
    return math.floor(PER_OCTAVE * math.log2(step) + 1e-9)


def _functions(z: Blocks) -> tuple[Blocks, Blocks, Blocks]:
    """phi_1(z), phi_2(z) and phi_3(z)."""
    largest = float(np.abs(z).sum(axis=-1).max())
    doublings = max(0, math.ceil(math.log2(largest / SMALL))) if largest > 0.0 else 0
    z = z / 2.0**doublings
    one = np.broadcast_to(np.eye(z.shape[-1], dtype=complex), z.shape)
    # phi_3 = 1/6 + z/24 + z^2/120 + ..., by Horner's rule.
    third = one / math.factorial(TERMS + 3)
    for power in range(TERMS - 1, -1, -1):
        third = one / math.factorial(power + 3) + z @ third
    second = 0.5 * one + z @ third
    first = one + z @ second
    for _ in range(doublings):
        exponential = one + z @ first
        third = 0.125 * (first @ second + second + 2.0 * third)
        second = 0.25 * (first @ first + 2.0 * second)
        first = 0.5 * first @ (exponential + one)
        z = 2.0 * z
    return first, second, third
