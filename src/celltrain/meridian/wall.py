"""The tube's wall, wave by wave.

In free space the cells' flow, periodic along the tube, is a sum of waves k = (2 pi j + q)/L on the
wall, at the radius a. The regular flow with that boundary value is taken from it:

    u = -(1/4 pi L) sum_k e^{ikz} N(r) W sum e^{-ikz'} N(r')^T f,

N(r) the flow inside from unit velocities on the wall, W the velocity on the wall of unit rings of
force (see `wall_response`); by reciprocity N(r')^T is also what forces inside are on the wall. With
Z = i sign(k) Z' both are real, and real and imaginary parts of the sums are rows of their own:

    e^{-ikz}(R, Phi, Z') -> (cos R, cos Phi, -s sin Z) + i (-sin R, -sin Phi, -s cos Z), s = sign k.

k_max = -log(tolerance)/(2 wall_distance). At q = 0 the wave k = 0 is there, too.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from jaxtyping import Complex, Float

from celltrain.meridian import functionals
from celltrain.meridian.bessel import bessel_i, bessel_k
from celltrain.meridian.grids import Amplitudes, Meridian
from celltrain.meridian.wall_response import (
    response,
    ring_velocity,
    uniform_response,
    uniform_ring_velocity,
)

#: Waves below this, in 1/r0, are the uniform one.
UNIFORM = 1e-12
#: Bytes that a group of waves may take, and the numbers for each wave and place: responses, rows
#: of them, and what those are made of.
GROUP, FIELDS = 2**28, 90

Sums = Float[np.ndarray, "part wave wall member"]
Functionals = tuple[np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True)
class WallWaves:
    """The waves of one phase q, with the Bessel functions at all places.

    `rho` and `z` are distances from the axis and axial positions of the places: of the sources,
    whose number is `sources`, then of the targets. Bessel functions are made below `orders`.
    `part`: which of the waves are meant, from and up to, all unless given.
    """

    phase: float
    radius: float
    period: float
    wall_distance: float
    tolerance: float
    rho: Meridian
    z: Meridian
    sources: int
    orders: int
    part: tuple[int, int] | None = None

    def groups(self) -> "tuple[WallWaves, ...]":
        """The same waves in groups that take little memory each: in thin films there are many.

        What they add at the wall is the sum of what the groups add.
        """
        count = self.waves.size
        most = max(1, GROUP // (FIELDS * 8 * self.rho.size))
        if count <= most:
            return (self,)
        number = -(-count // most)
        edges = np.linspace(0, count, number + 1).astype(int).tolist()
        return tuple(replace(self, part=part) for part in pairwise(edges))

    @cached_property
    def waves(self) -> Meridian:
        """k, without the uniform wave, 1/r0."""
        return self._every if self.part is None else self._every[slice(*self.part)]

    @cached_property
    def _every(self) -> Meridian:
        largest = -np.log(self.tolerance) / (2.0 * self.wall_distance)
        count = int(np.ceil(largest * self.period / (2.0 * np.pi))) + 1
        waves = (2.0 * np.pi * np.arange(-count, count + 1) + self.phase) / self.period
        return waves[np.abs(waves) > UNIFORM]

    @property
    def uniform(self) -> bool:
        """Whether k = 0 is among the waves."""
        first = self.part is None or self.part[0] == 0
        return first and abs(self.phase) / self.period <= UNIFORM

    @cached_property
    def all_waves(self) -> Meridian:
        """k, the uniform wave last."""
        return np.append(self.waves, 0.0) if self.uniform else self.waves

    @cached_property
    def _half(self) -> tuple[Meridian, np.ndarray]:
        """The different |k|, and which of them belongs to each wave."""
        size, place = np.unique(np.round(np.abs(self.waves), 12), return_inverse=True)
        return size, place

    @cached_property
    def _bessel(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        size, _ = self._half
        inside = bessel_i(np.outer(size, self.rho), self.orders)
        on_wall = bessel_i(size * self.radius, self.orders)
        return inside, on_wall, bessel_k(size * self.radius, self.orders)

    def response(self, m: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """N, dN/dr [wave, wall, 3, place] and the pressure of its columns [wave, wall, place]."""
        size, place = self._half
        inside, on_wall, _ = self._bessel
        found = response(m, size, self.radius, self.rho, inside, on_wall)
        parts = tuple(each[place] for each in found)
        if self.uniform:
            still = uniform_response(m, self.radius, self.rho)
            parts = tuple(np.concatenate(pair) for pair in zip(parts, still, strict=True))
        return parts[0], parts[1], parts[2]

    def ring_velocity(self, m: int) -> Float[np.ndarray, "wave 3 3"]:
        """W times -1/(4 pi L)."""
        size, place = self._half
        _, on_wall, decaying = self._bessel
        found = ring_velocity(m, size, self.radius, on_wall, decaying)[place]
        if self.uniform:
            found = np.concatenate([found, uniform_ring_velocity(m)])
        return found * (-1.0 / (4.0 * np.pi * self.period))


class WallFlow:
    """What the wall adds for one azimuthal number and phase: rows of sources and of targets."""

    def __init__(self, waves: WallWaves, m: int) -> None:
        self.m = m
        self._waves = waves
        self._rings = waves.ring_velocity(m)
        self._response = waves.response(m)
        k = waves.all_waves
        self._k = k
        turn = k[:, None] * waves.z
        self._cosine, self._sine = np.cos(turn), np.sin(turn)
        self._sign = np.where(k < 0.0, -1.0, 1.0)[:, None]

    def _rows(self, response: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Real and imaginary rows of e^{-ikz} N at the sources, [wave, wall, 3, source]."""
        here = slice(None, self._waves.sources)
        values = response[..., here]
        cosine, sine = self._cosine[:, None, here], self._sine[:, None, here]
        sign = self._sign[:, None]
        real, imaginary = np.empty_like(values), np.empty_like(values)
        real[:, :, :2] = cosine[:, :, None] * values[:, :, :2]
        real[:, :, 2] = -sign * sine * values[:, :, 2]
        imaginary[:, :, :2] = -sine[:, :, None] * values[:, :, :2]
        imaginary[:, :, 2] = -sign * cosine * values[:, :, 2]
        return real, imaginary

    def _functionals(self) -> tuple[Functionals, Functionals]:
        """(value, slope in r, slope in z) of the real and of the imaginary rows."""
        value, slope, _ = self._response
        (real, imaginary), (real_r, imaginary_r) = self._rows(value), self._rows(slope)
        k = self._k[:, None, None, None]
        # d/dz e^{-ikz} = -ik e^{-ikz}.
        return (real, real_r, k * imaginary), (imaginary, imaginary_r, -k * real)

    def of_forces(
        self,
        force: tuple[Meridian, Meridian],
        displacements: Amplitudes,
        forces: Amplitudes,
    ) -> Sums:
        """What changed forces and places of the sources are on the wall.

        **Arguments:** `force`: axial and radial component at the sources; `displacements` and
        `forces` of the members, as amplitudes times solid angles.
        """
        rho = self._waves.rho[: self._waves.sources]
        sums = []
        for rows in self._functionals():
            moved = functionals.moved(*rows, self.m, rho, force)
            sums.append(_flat(rows[0]) @ forces + _flat(moved) @ displacements)
        return self._shaped(sums)

    def of_resting_forces(self, forces: Amplitudes) -> Sums:
        """What forces at unmoved places are on the wall."""
        value, *_ = self._response
        return self._shaped([_flat(rows) @ forces for rows in self._rows(value)])

    def of_stresses(
        self,
        area: tuple[Meridian, Meridian],
        displacements: Amplitudes,
    ) -> Sums:
        """What the double layer of displacements of the sources is on the wall."""
        here = slice(None, self._waves.sources)
        rho = self._waves.rho[here]
        *_, pressure = self._response
        turns = self._cosine[:, None, here], -self._sine[:, None, here]
        sums = []
        for rows, turn in zip(self._functionals(), turns, strict=True):
            stressed = functionals.stressed(*rows, pressure[..., here] * turn, self.m, rho, area)
            sums.append(_flat(stressed) @ displacements)
        return self._shaped(sums)

    def _shaped(self, sums: list[np.ndarray]) -> Sums:
        shape = (2, len(self._k), 3, sums[0].shape[-1])
        return np.einsum("kij,pkjn->pkin", self._rings, np.stack(sums).reshape(shape))

    def velocity(self, sums: Sums) -> Complex[np.ndarray, "target 3 member"]:
        """The velocity at the targets."""
        return self._at_targets(self._response[0], sums)

    def gradient(
        self, sums: Sums
    ) -> tuple[Complex[np.ndarray, "target 3 member"], Complex[np.ndarray, "target 3 member"]]:
        """Its derivatives in r and z at the targets."""
        k = self._k[:, None, None]
        # d/dz: times ik.
        turned = np.stack([-k * sums[1], k * sums[0]])
        value, slope, _ = self._response
        return self._at_targets(slope, sums), self._at_targets(value, turned)

    def _at_targets(self, response: np.ndarray, sums: Sums) -> np.ndarray:
        there = slice(self._waves.sources, None)
        values = response[..., there]
        cosine, sine = self._cosine[:, None, there], self._sine[:, None, there]
        sign = self._sign[:, None]
        # e^{ikz} N S for R and Phi; for Z = i s Z' times i s.
        turned, leaning = np.empty_like(values), np.empty_like(values)
        turned[:, :, :2] = cosine[:, :, None] * values[:, :, :2]
        turned[:, :, 2] = -sign * sine * values[:, :, 2]
        leaning[:, :, :2] = sine[:, :, None] * values[:, :, :2]
        leaning[:, :, 2] = sign * cosine * values[:, :, 2]
        by_target = [
            np.ascontiguousarray(np.moveaxis(each, 3, 0).transpose(0, 3, 1, 2)).reshape(
                3 * values.shape[-1], -1
            )
            for each in (turned, leaning)
        ]
        real, imaginary = (each.reshape(-1, each.shape[-1]) for each in sums)
        found = by_target[0] @ real - by_target[1] @ imaginary + 0j
        found.imag = by_target[1] @ real + by_target[0] @ imaginary
        return found.reshape(values.shape[-1], 3, -1)


def _flat(rows: np.ndarray) -> np.ndarray:
    """[wave wall, 3 point]."""
    return rows.reshape(rows.shape[0] * rows.shape[1], -1)
