"""All images of a cell beyond the nearest ones, in closed form.

With 1/|d| = int J_0(lam rho) e^{-lam |dz|} dlam the images |p| > P are sums over nodes lam. For
each lam and direction (up: images above the target, E = e^{-lam z'}; down: images below, E =
e^{lam z'}) the sources enter by four moments of their amplitudes of azimuthal number m,

    a = J_m Z E,   b+- = J_{m+-1} (R +- Phi) E,   gamma = a -/+ sigma (up/down), zeta = z' gamma,

sigma = (b- - b+)/2. One image at the axial distance s has the velocity

    u_z = e^{-lam s} J_m [a + lam s gamma],
    u_+- = e^{-lam s} J_{m+-1} [2 b+- +- sigma -(up)/+(down) (+-) lam s gamma],

and the sum over |p| > P, with e = e^{+-iq - lam L} and f = e^{P+1}, replaces 1 by G0 = f/(1 - e), s
gamma by G1 L gamma +(up)/-(down) G0 (zeta - z_t gamma), G1 = f ((P + 1) - P e)/(1 - e)^2.
Prefactor 1/8 pi. The moments serve all q.
"""

import numpy as np
from jaxtyping import Complex, Float

from celltrain.meridian import functionals
from celltrain.meridian.bessel import bessel_j
from celltrain.meridian.grids import Amplitudes, Meridian

#: Gauss points in each of the panels, which double in length away from 0.
PANEL_POINTS = 12
# e^{-lam s} below the tolerance by this factor ends the integral.
MARGIN = 1.3

Moments = Float[np.ndarray, "direction moment node member"]
Targets = Float[np.ndarray, " target"]
Velocity = Complex[np.ndarray, "target 3 member"]


class Tail:
    """The images |p| > `nearest` of the sources, at the targets; prefactors included.

    `distance` is the least axial distance of such an image, `smallest_phase` the smallest q > 0
    that it has to serve: the integrand has a pole at lam = iq/L.
    """

    def __init__(
        self,
        *,
        period: float,
        nearest: int,
        distance: float,
        smallest_phase: float,
        tolerance: float,
        sources: tuple[Meridian, Meridian],
        targets: tuple[Targets, Targets],
        orders: int,
    ) -> None:
        self.period, self.nearest = period, nearest
        largest = -MARGIN * np.log(tolerance) / distance
        panels = max(5, int(np.ceil(np.log2(largest * period / smallest_phase))) + 1)
        edges = np.append(0.0, largest * 2.0 ** np.arange(-panels, 1))
        x, gauss = np.polynomial.legendre.leggauss(PANEL_POINTS)
        middle, half = 0.5 * (edges[1:] + edges[:-1]), 0.5 * np.diff(edges)
        self.nodes: Meridian = (middle[:, None] + half[:, None] * x).ravel()
        self.weights: Meridian = (half[:, None] * gauss).ravel() / (8.0 * np.pi)
        (self._z, self._rho), (self._z_target, self._rho_target) = sources, targets
        self._at_sources = bessel_j(np.outer(self.nodes, self._rho), orders)
        self._at_targets = bessel_j(np.outer(self.nodes, self._rho_target), orders)

    # ------------------------------------------------------------------------------- the sources

    def of_forces(
        self,
        m: int,
        force: tuple[Meridian, Meridian],
        displacements: Amplitudes,
        forces: Amplitudes,
    ) -> Moments:
        """Moments of changed forces and places of the sources (as in `WallFlow.of_forces`)."""
        value, radial, axial, _ = self._functionals(m)
        moved = functionals.moved(value, radial, axial, m, self._rho, force)
        return self._products(value, forces) + self._products(moved, displacements)

    def of_resting_forces(self, m: int, forces: Amplitudes) -> Moments:
        """Moments of forces at unmoved places."""
        return self._products(self._functionals(m)[0], forces)

    def of_stresses(
        self,
        m: int,
        area: tuple[Meridian, Meridian],
        displacements: Amplitudes,
    ) -> Moments:
        """Moments of the double layer of displacements of the sources."""
        value, radial, axial, pressure = self._functionals(m)
        rows = functionals.stressed(value, radial, axial, pressure, m, self._rho, area)
        return self._products(rows, displacements)

    def _products(self, rows: np.ndarray, content: np.ndarray) -> Moments:
        shape = rows.shape[:3]
        return (rows.reshape(np.prod(shape), -1) @ content).reshape(*shape, -1)

    def _functionals(self, m: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """a, b+, b-, zeta as functionals [direction, moment, node, 3, source], and their slopes.

        The last is the pressure of the flow that each stands for: 2 J_m E for zeta.
        """
        (low, mid, high), (low_r, mid_r, high_r) = _near_orders(m, self._at_sources, self.nodes)
        shape = (2, 4, *mid.shape[:1], 3, self._rho.size)
        value, radial, axial = np.zeros(shape), np.zeros(shape), np.zeros(shape)
        pressure = np.zeros((2, 4, *mid.shape))
        for direction, sign in enumerate((-1.0, 1.0)):
            fall = np.exp(sign * np.outer(self.nodes, self._z))
            for rows, (j_low, j_mid, j_high) in (
                (value[direction], (low * fall, mid * fall, high * fall)),
                (radial[direction], (low_r * fall, mid_r * fall, high_r * fall)),
            ):
                rows[0, :, 2] = j_mid
                rows[1, :, 0] = rows[1, :, 1] = j_high
                rows[2, :, 0], rows[2, :, 1] = j_low, -j_low
                # gamma = a - sigma (up), a + sigma (down).
                rows[3] = rows[0] + 0.5 * sign * (rows[2] - rows[1])
            rate = (sign * self.nodes)[:, None, None]
            axial[direction] = rate * value[direction]
            # zeta = z' gamma.
            axial[direction, 3] = self._z * axial[direction, 3] + value[direction, 3]
            value[direction, 3] *= self._z
            radial[direction, 3] *= self._z
            pressure[direction, 3] = 2.0 * mid * fall
        return value, radial, axial, pressure

    # ------------------------------------------------------------------------------- the targets

    def velocity(self, m: int, phase: float, moments: Moments) -> Velocity:
        """The velocity at the targets."""
        matrices, _ = self._matrices(m)
        up, down = (
            self._applied(matrix, *self._summed(direction, phase, moments))
            for direction, matrix in enumerate(matrices)
        )
        return up + down

    def gradient(self, m: int, phase: float, moments: Moments) -> tuple[Velocity, Velocity]:
        """Its derivatives in r and z at the targets."""
        matrices, slopes = self._matrices(m)
        by_radius: Velocity = np.zeros(1)
        by_height: Velocity = np.zeros(1)
        for direction, sign in enumerate((1.0, -1.0)):
            fixed, linear = self._summed(direction, phase, moments)
            by_radius = by_radius + self._applied(slopes[direction], fixed, linear)
            # d/dz of e^{+-lam z} (fixed + z linear).
            rate = (sign * self.nodes)[:, None]
            turned = np.concatenate([rate * part for part in np.split(fixed, 4)])
            turned[-len(rate) :] += linear
            by_height = by_height + self._applied(matrices[direction], turned, rate * linear)
        return by_radius, by_height

    def _summed(
        self, direction: int, phase: float, moments: Moments
    ) -> tuple[np.ndarray, np.ndarray]:
        """Sums over the images: what is fixed, and what is proportional to the target's z."""
        sign, lam, n = (1.0 if direction == 0 else -1.0), self.nodes, self.nearest
        exponent = sign * 1j * phase - lam * self.period
        e, f = np.exp(exponent), np.exp((n + 1) * exponent)
        plain = (self.weights * f / (1.0 - e))[:, None]
        spaced = (self.weights * self.period * f * ((n + 1) - n * e) / (1.0 - e) ** 2)[:, None]
        a, plus, minus, zeta = moments[direction]
        gamma = a - 0.5 * sign * (minus - plus)
        lam = lam[:, None]
        apart = lam * (spaced * gamma + sign * plain * zeta)
        return (
            np.concatenate([plain * a, plain * plus, plain * minus, apart]),
            -sign * lam * plain * gamma,
        )

    def _applied(self, matrix: np.ndarray, fixed: np.ndarray, linear: np.ndarray) -> Velocity:
        """From the sums to the velocities, in real arithmetic."""
        count = len(self._z_target)
        flat = matrix.reshape(3 * count, -1)
        along = (matrix[:, :, 3] * self._z_target[:, None, None]).reshape(3 * count, -1)
        found = flat @ np.ascontiguousarray(fixed).view(float)
        found += along @ np.ascontiguousarray(linear).view(float)
        return found.view(complex).reshape(count, 3, -1)

    def _matrices(self, m: int) -> tuple[np.ndarray, np.ndarray]:
        """From (a, b+, b-, lam s gamma) to R, Phi, Z [direction, target, 3, moment, node].

        Also its derivative in r.
        """
        found = []
        for low, mid, high in _near_orders(m, self._at_targets, self.nodes):
            matrix = np.zeros((2, self._rho_target.size, 3, 4, self.nodes.size))
            for direction, sign in enumerate((-1.0, 1.0)):
                fall = np.exp(-sign * np.outer(self.nodes, self._z_target))
                j_low, j_mid, j_high = ((each * fall).T for each in (low, mid, high))
                rows = matrix[direction]
                rows[:, 2, 0] = rows[:, 2, 3] = j_mid
                rows[:, 0, 1] = 0.5 * (1.5 * j_high + 0.5 * j_low)
                rows[:, 1, 1] = 0.5 * (1.5 * j_high - 0.5 * j_low)
                rows[:, 0, 2] = 0.5 * (0.5 * j_high + 1.5 * j_low)
                rows[:, 1, 2] = 0.5 * (0.5 * j_high - 1.5 * j_low)
                rows[:, 0, 3] = 0.5 * sign * (j_high - j_low)
                rows[:, 1, 3] = 0.5 * sign * (j_high + j_low)
            found.append(matrix)
        return found[0], found[1]


def _near_orders(
    m: int, table: Float[np.ndarray, "order node point"], nodes: Float[np.ndarray, " node"]
) -> tuple[tuple[np.ndarray, ...], tuple[np.ndarray, ...]]:
    """J_{m-1}, J_m and J_{m+1} of lam r, and their derivatives in r."""

    def order(n: int) -> np.ndarray:
        return table[n] if n >= 0 else (-1.0) ** n * table[-n]

    half = 0.5 * nodes[:, None]
    values = tuple(order(n) for n in (m - 1, m, m + 1))
    slopes = tuple(half * (order(n - 1) - order(n + 1)) for n in (m - 1, m, m + 1))
    return values, slopes
