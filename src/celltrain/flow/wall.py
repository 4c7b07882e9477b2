"""The no-slip wall of a straight round tube, by separation of variables.

The flow that takes given values on the wall and is regular inside is known mode by mode. For
exp(i(m theta + k z)), k != 0, in the components (u_r, u_theta/i, u_z/i) and with I_n = I_n(x), x =
|k| r, it is a combination, with coefficients fixed at r = R, of

    (I_(m-1), I_(m-1), I_m),   (I_(m+1), -I_(m+1), I_m),
    (x I_(m+2) + m I_(m+1), (m + 2) I_(m+1), x I_(m+1)),

turned for negative m and k: those of Happel & Brenner 1983, section 3.3, recombined, as theirs
become parallel as k -> 0. For m = 0 the first two are replaced by (I_1, 0, I_0) and (0, I_1, 0),
and the third by (x I_2, 0, x I_1). For k = 0, u_z ~ r^|m| and (u_r, u_theta) are combinations of
r^(|m| - 1) and r^(|m| + 1); for m = 0 only a rigid rotation. The radial functions are kept as
Chebyshev coefficients, which makes the evaluation at any point a Fourier sum in theta, z and
arccos(r/R). They depend on k R alone, so a tube's radius and period may vary (`response_slope`).
"""

import math
from collections.abc import Callable
from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax_finufft import nufft2
from jaxtyping import Array, Complex, Float, Int
from scipy.special import hyp0f1, ive

from celltrain.flow.shared_sizes import shared_size
from celltrain.runtime import NUFFT_OPTIONS

Cylindrical = tuple[Array, Array, Array]

# Points across a strip along the tube.
STRIP = 8
# Bessel functions of the wall's modes below this are not formed: they would underflow.
LEAST_BESSEL = 1e-200


# I_n(k r)/I_m(k R) for n = m - 1, m, m + 1, m + 2, each [wave, node].
Ratios = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def _bessel_ratios(order: int, waves: np.ndarray, radius: float, r: np.ndarray) -> Ratios:
    """I_n(k r)/I_m(k R) for n = m - 1, m, m + 1, m + 2, free of overflow and underflow."""
    plain = (order == 0) | (ive(order + 2, waves * radius) > LEAST_BESSEL)
    ratios = np.empty((4, waves.size, r.size))
    ratios[:, plain] = _scaled_ratios(order, waves[plain, None], radius, r)
    ratios[:, ~plain] = _series_ratios(order, waves[~plain, None], radius, r)
    below, value, above, beyond = ratios
    return below, value, above, beyond


def _scaled_ratios(order: int, wave: np.ndarray, radius: float, r: np.ndarray) -> np.ndarray:
    """By functions without their exponential growth."""
    scale = np.exp(wave * (r - radius)) / ive(order, wave * radius)
    neighbours = np.array([abs(order - 1), order, order + 1, order + 2])
    return ive(neighbours[:, None, None], wave * r) * scale


def _series_ratios(order: int, wave: np.ndarray, radius: float, r: np.ndarray) -> np.ndarray:
    """By I_n(x) = (x/2)^n/n! 0F1(n + 1; x^2/4), of which the power underflows, for m > 0."""
    half = 0.5 * wave
    whole = hyp0f1(order + 1.0, (half * radius) ** 2)
    step = half * radius / (order + 1.0)
    powers = (order / (half * radius), 1.0, step, step * half * radius / (order + 2.0))
    return np.stack(
        [
            power * hyp0f1(n + 1.0, (half * r) ** 2) * (r / radius) ** n / whole
            for n, power in enumerate(powers, order - 1)
        ]
    )


def _axial_solutions(order: int, ratios: Ratios, x: np.ndarray) -> np.ndarray:
    """The three solutions [wave, component, solution, node] for m >= 0, k > 0; linear in x."""
    below, value, above, beyond = ratios
    none = np.zeros_like(value)
    if order == 0:
        rows = [[above, none, x * beyond], [none, above, none], [value, none, x * above]]
    else:
        rows = [
            [below, above, x * beyond + order * above],
            [below, -above, (order + 2) * above],
            [value, value, x * above],
        ]
    return np.moveaxis(np.array(rows), 2, 0)


def _axial_response(order: int, waves: np.ndarray, radius: float, nodes: np.ndarray) -> np.ndarray:
    """Radial functions [wave, out, in, node] of m >= 0, k > 0 for unit boundary values.

    Components are (u_r, u_theta/i, u_z/i), in which the system is real.
    """
    r = np.append(nodes, radius)
    found = _axial_solutions(order, _bessel_ratios(order, waves, radius, r), waves[:, None] * r)
    return _fitted(found, found)


def _axial_slope(order: int, waves: np.ndarray, radius: float, nodes: np.ndarray) -> np.ndarray:
    """k d/dk of `_axial_response`."""
    r = np.append(nodes, radius)
    ratios, x = _bessel_ratios(order, waves, radius, r), waves[:, None] * r
    below, value, above, beyond = ratios
    # x I_n' = n I_n + x I_(n+1) = x I_(n-1) - n I_n; what they are divided by does not matter.
    slopes = (
        (order - 1) * below + x * value,
        order * value + x * above,
        (order + 1) * above + x * beyond,
        x * above - (order + 2) * beyond,
    )
    found = _axial_solutions(order, ratios, x)
    moved = _axial_solutions(order, slopes, x) + found - _axial_solutions(order, ratios, 0.0 * x)
    moved = moved - np.einsum("koin,kic->kocn", _fitted(found, found, ends=True), moved[..., -1])
    return _fitted(moved, found)


def _fitted(functions: np.ndarray, solutions: np.ndarray, *, ends: bool = False) -> np.ndarray:
    """The functions, combined as the solutions are to take unit values at the last node.

    That node is left out unless `ends`.
    """
    # Columns scaled before the solve: for small k they differ by orders of magnitude.
    size = np.abs(solutions[..., -1]).max(axis=1, keepdims=True)
    inverse = np.linalg.inv(solutions[..., -1] / size)
    nodes = functions if ends else functions[..., :-1]
    return np.einsum("kocn,kci->koin", nodes, inverse / np.swapaxes(size, 1, 2))


def _uniform_response(order: int, radius: float, nodes: np.ndarray) -> np.ndarray:
    """Radial functions [out, in, node] of m >= 0, k = 0 for unit boundary values."""
    r = nodes / radius
    response = np.zeros((3, 3, nodes.size))
    response[2, 2] = r**order
    if order == 0:
        response[1, 1] = r
        return response
    low, high = r ** (order - 1), r ** (order + 1)
    slope = (order + 2) / order
    basis = np.array([[low, high], [low, slope * high]])
    at_wall = np.array([[1.0, 1.0], [1.0, slope]])
    response[:2, :2] = np.einsum("ocn,ci->oin", basis, np.linalg.inv(at_wall))
    return response


class TubeWall(eqx.Module):
    """Wall points and the regular flow that takes given values there.

    `response` holds the Chebyshev coefficients (degree below 2 * nodes, of the parity of the
    function) for each azimuthal number and axial wave number, [out, in, m, k, chebyshev]. `axial`
    are the wave numbers in radians per period, all with `phase` added to whole turns.
    """

    tolerance: float = eqx.field(static=True)
    radius: Float[Array, ""]
    period: Float[Array, ""]
    phase: Float[Array, ""]
    orders: Float[Array, " m"]
    axial: Float[Array, " k"]
    response: Float[Array, "3 3 m k chebyshev"]

    def response_slope(self) -> Float[np.ndarray, "3 3 m k chebyshev"]:
        """d(response)/d log(R/period)."""
        return _responses(self, _axial_slope, lambda order, radius, nodes: np.zeros(()))

    def resized(
        self, radius: Float[Array, ""], period: Float[Array, ""], slope: Array
    ) -> "TubeWall":
        """The wall of another radius and period, its response to first order.

        **Arguments:** `slope`: see `response_slope`.
        """
        change = jnp.log(radius / self.radius) - jnp.log(period / self.period)
        return replace(self, radius=radius, period=period, response=self.response + change * slope)

    def points(self) -> Float[Array, "k m 3"]:
        """Wall points [z, theta, 3]: uniform, as many as modes."""
        theta = 2.0 * math.pi * jnp.arange(self.orders.size) / self.orders.size
        z = self.period * jnp.arange(self.axial.size) / self.axial.size
        theta, z = theta[None, :], z[:, None]
        return jnp.stack(
            jnp.broadcast_arrays(self.radius * jnp.cos(theta), self.radius * jnp.sin(theta), z),
            axis=-1,
        )

    def strips(self) -> tuple[Int[np.ndarray, "strip place"], Int[np.ndarray, " point"]]:
        """Numbers of the points of narrow strips along the tube, and where each point is in them.

        The last strip is filled up with points that it has already.
        """
        rows, columns = self.axial.size, self.orders.size
        count = -(-columns // STRIP)
        theta = np.minimum(np.arange(count * STRIP), columns - 1).reshape(count, 1, STRIP)
        points = np.arange(rows)[:, None] * columns + theta
        z, theta = np.divmod(np.arange(rows * columns), columns)
        return points.reshape(count, -1), (theta // STRIP * rows + z) * STRIP + theta % STRIP

    def regular_flow(self, boundary: Complex[Array, "k m 3"]) -> Complex[Array, "3 m k chebyshev"]:
        """Coefficients of the cylindrical components of the flow with this boundary velocity."""
        n_z, n_theta, _ = boundary.shape
        theta = 2.0 * math.pi * jnp.arange(n_theta) / n_theta
        turn = jnp.arange(n_z)[:, None] / n_z
        u_x, u_y, u_z = (boundary[..., i] * jnp.exp(-1j * self.phase * turn) for i in range(3))
        cylindrical = jnp.stack(
            [
                u_x * jnp.cos(theta) + u_y * jnp.sin(theta),
                -1j * (u_y * jnp.cos(theta) - u_x * jnp.sin(theta)),
                -1j * u_z,
            ]
        )
        modes = jnp.fft.fft2(cylindrical, norm="forward")
        modes = jnp.fft.fftshift(modes, axes=(1, 2)).swapaxes(1, 2)
        solved = jnp.einsum("oimkn,imk->omkn", self.response, modes)
        return solved * jnp.array([1.0, 1j, 1j]).reshape(3, 1, 1, 1)

    def at_rings(
        self, points: Float[Array, "ring azimuth 3"], flow: Complex[Array, "3 m k chebyshev"]
    ) -> Complex[Array, "ring azimuth 3"]:
        """The flow at points in rings about the axis; derivatives in any direction are exact."""
        # In parts of radius and period, so that nothing else in there depends on these.
        parts = points / jnp.stack([self.radius, self.radius, self.period])
        return _to_cartesian(points, _ring_flow(self.orders, self.axial, parts, flow))

    def at_points(
        self, points: Float[Array, "ring azimuth 3"], flow: Complex[Array, "3 m k chebyshev"]
    ) -> Float[Array, "ring azimuth 3"]:
        """The flow at any points inside the tube; only for a train without axial shift."""
        # On the axis the cylindrical components have no direction: step off it by 1e-9.
        on_axis = points[..., 0] ** 2 + points[..., 1] ** 2 < 1e-18
        points = points.at[..., 0].add(jnp.where(on_axis, 1e-9, 0.0))
        loose = points.reshape(-1, 3)
        square = loose[:, 0] ** 2 + loose[:, 1] ** 2
        theta = jnp.arctan2(loose[:, 1], loose[:, 0])
        psi = jnp.arccos(jnp.clip(jnp.sqrt(square) / self.radius, 0.0, 1.0))
        # sum_n c_n cos(n psi) as a Fourier sum over -n .. n.
        half = 0.5 * flow
        both = jnp.concatenate([half[..., :0:-1], flow[..., :1], half[..., 1:]], axis=-1)
        angle_z = 2.0 * math.pi * (loose[:, 2] / self.period)
        angle_z = angle_z - 2.0 * math.pi * jnp.round(loose[:, 2] / self.period)
        # The components are real: two of them share one complex transform.
        pairs = jnp.stack([both[0] + 1j * both[1], both[2]])
        sums = nufft2(pairs, theta, angle_z, psi, eps=self.tolerance, iflag=1, opts=NUFFT_OPTIONS)
        cylindrical = jnp.stack([sums[0].real, sums[0].imag, sums[1].real], axis=-1)
        return _to_cartesian(points, cylindrical.reshape(points.shape))


def _ring_sums(orders: Array, axial: Array, points: Array, flow: Array, slope: bool) -> Array:
    """Cylindrical components at rings in parts of radius and period, or their radial slopes."""
    angle = jnp.arccos(jnp.hypot(points[:, 0, 0], points[:, 0, 1]))[:, None]
    n = jnp.arange(flow.shape[-1])
    radial = jnp.cos(n * angle)
    if slope:
        radial = n * jnp.sin(n * angle) / jnp.sin(angle)
    along = jnp.exp(1j * points[:, 0, 2:] * axial)
    theta = jnp.arctan2(points[..., 1], points[..., 0])
    turn = jnp.exp(1j * theta[..., None] * orders)
    by_ring = jnp.einsum("rk,cmkn->rcmn", along, flow)
    by_ring = jnp.einsum("rn,rcmn->rcm", radial.astype(complex), by_ring)
    return jnp.einsum("ram,rcm->rac", turn, by_ring)


@jax.custom_jvp
def _ring_flow(orders: Array, axial: Array, points: Array, flow: Array) -> Array:
    return _ring_sums(orders, axial, points, flow, False)


@_ring_flow.defjvp
def _ring_flow_jvp(primals, tangents):  # type: ignore[no-untyped-def]
    orders, axial, points, flow = primals
    _, _, d_points, d_flow = tangents
    square = points[..., 0] ** 2 + points[..., 1] ** 2
    radius = jnp.sqrt(square)
    d_radius = points[..., 0] * d_points[..., 0] + points[..., 1] * d_points[..., 1]
    d_theta = points[..., 0] * d_points[..., 1] - points[..., 1] * d_points[..., 0]
    change = _ring_sums(orders, axial, points, d_flow, False)
    for step, factor, slope in (
        (d_radius / radius, 1.0, True),
        (d_theta / square, 1j * orders[:, None, None], False),
        (d_points[..., 2], 1j * axial[:, None], False),
    ):
        change = change + step[..., None] * _ring_sums(orders, axial, points, factor * flow, slope)
    return _ring_flow(orders, axial, points, flow), change


def _to_cartesian(points: Array, cylindrical: Array) -> Array:
    radius = jnp.sqrt(points[..., 0] ** 2 + points[..., 1] ** 2)
    cosine, sine = points[..., 0] / radius, points[..., 1] / radius
    u_r, u_theta, u_z = (cylindrical[..., i] for i in range(3))
    return jnp.stack([u_r * cosine - u_theta * sine, u_r * sine + u_theta * cosine, u_z], axis=-1)


def tube_wall(
    radius: float,
    period: float,
    *,
    gap: float,
    tolerance: float,
    phase: float = 0.0,
    shared: bool = False,
) -> TubeWall:
    """Wall of a tube, fine enough for surfaces at a distance of `gap` or more.

    The velocity on the wall that a source at that distance gives has modes that fall as
    exp(-k gap), and so does their effect back at that distance; both are resolved to `tolerance`.

    **Arguments:** `phase` (radians per period) is added to every axial wave number (quasi-periodic
    flow); `shared`: take numbers of modes that many tubes have in common.
    """

    def size(count: int) -> int:
        return shared_size(count) if shared else count

    largest = -math.log(tolerance) / (1.4 * gap)
    n_theta = 2 * size(math.ceil(largest * radius)) + 1
    n_z = 2 * size(math.ceil(largest * period / (2.0 * math.pi))) + 1
    # Chebyshev degree for exp(k R x) to the tolerance, k the largest wave number.
    steep = largest * radius
    nodes_count = size(math.ceil(0.5 * math.sqrt(2.0 * steep * -math.log(tolerance))) + 8)
    full = 2 * nodes_count
    orders = np.arange(n_theta) - n_theta // 2
    axial = 2.0 * np.pi * (np.arange(n_z) - n_z // 2) + phase
    full_shape = (3, 3, n_theta, n_z, full)
    wall = TubeWall(
        tolerance=tolerance,
        radius=jnp.asarray(radius, dtype=float),
        period=jnp.asarray(period, dtype=float),
        phase=jnp.asarray(phase, dtype=float),
        orders=jnp.asarray(orders, dtype=float),
        axial=jnp.asarray(axial),
        response=jnp.zeros(full_shape),
    )
    return replace(wall, response=jnp.asarray(_responses(wall, _axial_response, _uniform_response)))


def _responses(
    wall: TubeWall,
    axial: Callable[[int, np.ndarray, float, np.ndarray], np.ndarray],
    uniform: Callable[[int, float, np.ndarray], np.ndarray],
) -> np.ndarray:
    """Chebyshev coefficients [out, in, m, k, chebyshev] of the radial functions of all modes.

    Those of -m and -k follow from those of m and k: with each sign a component changes its own.
    """
    radius, full = float(wall.radius), wall.response.shape[-1]
    psi = (np.arange(full // 2) + 0.5) * np.pi / full
    nodes = radius * np.cos(psi)
    to_chebyshev = np.cos(np.outer(np.arange(full), psi)) * (4.0 / full)
    to_chebyshev[0] *= 0.5
    # By symmetry the other half of the nodes doubles coefficients of the right parity.
    even = (np.arange(full) % 2 == 0)[:, None]
    k = np.asarray(wall.axial) / float(wall.period)
    waves, place = np.unique(np.abs(k), return_inverse=True)
    direction = np.where(k < 0.0, -1.0, 1.0)[:, None]
    orders = np.asarray(wall.orders).astype(int)
    response = np.zeros(wall.response.shape)
    for order in range(orders.max() + 1):
        values = np.zeros((waves.size, 3, 3, nodes.size))
        values[waves == 0.0] = uniform(order, radius, nodes)
        values[waves > 0.0] = axial(order, waves[waves > 0.0], radius, nodes)
        along = to_chebyshev * (even if order % 2 == 0 else ~even)
        across = to_chebyshev * (even if order % 2 else ~even)
        for o, i in np.ndindex(3, 3):
            found = (values[:, o, i] @ (along if o == 2 else across).T)[place]
            found *= direction if (o == 2) != (i == 2) else 1.0
            for m in {order, -order}:
                swaps = m < 0 and (o == 1) != (i == 1)
                response[o, i, orders == m] = -found if swaps else found
    return response
