"""The no-slip wall of a straight round tube, by separation of variables.

The flow that takes given values on the wall and is regular inside is known mode by mode. For
exp(i(m theta + k z)), k != 0, in the components (u_r, u_theta/i, u_z/i) and with I_n = I_n(x), x =
|k| r, it is a combination, with coefficients fixed at r = R, of

    (I_(m-1), I_(m-1), I_m),   (I_(m+1), -I_(m+1), I_m),
    (x I_(m+2) + m I_(m+1), (m + 2) I_(m+1), x I_(m+1)),

turned for negative m and k: those of Happel & Brenner 1983, section 3.3, recombined, as theirs
become parallel as k -> 0. For m = 0 the first two are replaced by (I_1, 0, I_0) and (0, I_1, 0),
and the third by (x I_2, 0, x I_1). For k = 0, u_z ~ r^|m| and (u_r, u_theta) are combinations of
r^(|m| - 1) and r^(|m| + 1); for m = 0 only a rigid rotation. The radial functions are kept at
Chebyshev nodes in 0 <= r <= R. The flow at any point is that on the cylinders of all nodes, Fourier
sums in theta and z, interpolated in r.
"""

import math
from typing import TypeAlias

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Complex, Float, Int
from scipy.special import hyp0f1, ive

from celltrain.flow.nonuniform import Angles, modes_to_points
from celltrain.runtime import constant

# Points across a strip along the tube.
STRIP = 8
# So many times the Chebyshev nodes that the hardest wave is estimated to take, and so many more:
# the error of the interpolation of cells' flows is then a fifth of the tolerance or less.
MARGIN, MORE = 1.14, 4
# Error of the transforms relative to the tolerance: near the wall modes fall more slowly than those
# of the resolved fields for which these are made.
TRANSFORM_SHARE = 0.01
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
    """The three solutions [wave, component, solution, node] for m >= 0, k > 0."""
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
    ratios = _bessel_ratios(order, waves, radius, r)
    return _fitted(_axial_solutions(order, ratios, waves[:, None] * r))


def _fitted(solutions: np.ndarray) -> np.ndarray:
    """The solutions, combined to take unit values at the last node, which is left out."""
    # Columns scaled before the solve: for small k they differ by orders of magnitude.
    size = np.abs(solutions[..., -1]).max(axis=1, keepdims=True)
    inverse = np.linalg.inv(solutions[..., -1] / size)
    combined = inverse / np.swapaxes(size, 1, 2)
    return np.einsum("kocn,kci->koin", solutions[..., :-1], combined)


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


#: Modes of a flow on the cylinders of each layer, [component, node, m, k].
RegularFlow: TypeAlias = tuple[Complex[Array, "3 _ _ _"], ...]


class TubeWall(eqx.Module):
    """Wall points and the regular flow that takes given values there.

    `response` holds the radial functions at Chebyshev nodes for each azimuthal number, from -n to
    n, and axial wave number, from 0 on: [out, in, node, m, k]. Nodes are in layers, from the wall
    inwards, each with half as many numbers as the one before, as short waves do not reach far.
    """

    tolerance: float = eqx.field(static=True)
    radius: Float[Array, ""]
    period: Float[Array, ""]
    response: tuple[Float[Array, "3 3 _ _ _"], ...]

    @property
    def azimuths(self) -> int:
        """Number of points around the wall, and of azimuthal numbers."""
        return self.response[0].shape[3]

    @property
    def rings(self) -> int:
        """Number of points along the wall, and of axial wave numbers of both signs."""
        return 2 * self.response[0].shape[4] - 1

    def points(self) -> Float[Array, "z azimuth 3"]:
        """Wall points [z, theta, 3]: uniform, as many as modes."""
        theta = 2.0 * math.pi * jnp.arange(self.azimuths) / self.azimuths
        z = self.period * jnp.arange(self.rings) / self.rings
        theta, z = theta[None, :], z[:, None]
        return jnp.stack(
            jnp.broadcast_arrays(self.radius * jnp.cos(theta), self.radius * jnp.sin(theta), z),
            axis=-1,
        )

    def strips(self) -> tuple[Int[np.ndarray, "strip place"], Int[np.ndarray, " point"]]:
        """Numbers of the points of narrow strips along the tube, and where each point is in them.

        The last strip is filled up with points that it has already.
        """
        rows, columns = self.rings, self.azimuths
        count = -(-columns // STRIP)
        theta = np.minimum(np.arange(count * STRIP), columns - 1).reshape(count, 1, STRIP)
        points = np.arange(rows)[:, None] * columns + theta
        z, theta = np.divmod(np.arange(rows * columns), columns)
        return points.reshape(count, -1), (theta // STRIP * rows + z) * STRIP + theta % STRIP

    def regular_flow(self, boundary: Float[Array, "z azimuth 3"]) -> RegularFlow:
        """Modes of the cylindrical components of the flow with these velocities, by layer.

        Waves of negative k are left out: the components are real.
        """
        theta = 2.0 * math.pi * jnp.arange(self.azimuths) / self.azimuths
        u_x, u_y, u_z = (boundary[..., i] for i in range(3))
        cylindrical = jnp.stack(
            [
                u_x * jnp.cos(theta) + u_y * jnp.sin(theta),
                u_y * jnp.cos(theta) - u_x * jnp.sin(theta),
                u_z,
            ]
        )
        modes = jnp.fft.rfft2(jnp.swapaxes(cylindrical, 1, 2), norm="forward")
        turns = jnp.array([1.0, 1j, 1j]).reshape(3, 1, 1, 1)
        modes = jnp.fft.fftshift(modes, axes=1)[:, None] / turns
        found = []
        for each in self.response:
            m, k = each.shape[3:]
            left_out = (self.azimuths - m) // 2
            kept = modes[..., left_out : left_out + m, :k]
            found.append(turns * sum(each[:, i] * kept[i] for i in range(3)))
        return tuple(found)

    def velocity(self, points: Float[Array, "point 3"], flow: RegularFlow) -> Array:
        """The flow at points inside the tube, [point, 3]."""
        # On the axis the cylindrical components have no direction: step off it by 1e-9.
        on_axis = points[:, 0] ** 2 + points[:, 1] ** 2 < 1e-18
        points = points.at[:, 0].add(jnp.where(on_axis, 1e-9, 0.0))
        radius = jnp.sqrt(points[:, 0] ** 2 + points[:, 1] ** 2)
        theta = jnp.arctan2(points[:, 1], points[:, 0])
        angles = jnp.stack([theta, points[:, 2] * (2.0 * math.pi / self.period)], axis=1)
        on_cylinders = jnp.concatenate([self._on_cylinders(each, angles) for each in flow], axis=2)
        weights = _interpolation(radius, self.radius, on_cylinders.shape[2])
        u_r, u_theta, u_z = jnp.einsum("pon,pn->op", on_cylinders, weights)
        cosine, sine = points[:, 0] / radius, points[:, 1] / radius
        return jnp.stack([u_r * cosine - u_theta * sine, u_r * sine + u_theta * cosine, u_z], -1)

    def _on_cylinders(self, flow: Array, angles: Angles) -> Float[Array, "point 3 node"]:
        """The components of a layer's flow at angles theta and z on the cylinders of its nodes."""
        fields = flow.reshape(-1, *flow.shape[2:])
        found = modes_to_points(fields, angles, TRANSFORM_SHARE * self.tolerance)
        return found.reshape(-1, *flow.shape[:2])


def _node_angles(count: int) -> Float[np.ndarray, " node"]:
    """Of Chebyshev nodes; the radius is R cos^2(psi/2)."""
    return (np.arange(count) + 0.5) * np.pi / count


def _interpolation(
    radius: Float[Array, " point"], largest: Float[Array, ""], count: int
) -> Float[Array, "point node"]:
    """Weights of values at the nodes in the polynomial through them."""
    # Both sides of r/R = cos^2(psi/2), so that no digits are lost near the axis or the wall.
    inside = jnp.maximum(largest - radius, 1e-300)
    psi = 2.0 * jnp.arctan2(jnp.sqrt(inside), jnp.sqrt(radius))
    orders = np.arange(count)
    to_chebyshev = np.cos(np.outer(orders, _node_angles(count))) * (2.0 / count)
    to_chebyshev[0] *= 0.5
    found: Array = jnp.cos(orders * psi[:, None]) @ constant(to_chebyshev)
    return found


def tube_wall(radius: float, period: float, *, wall_gap: float, tolerance: float) -> TubeWall:
    """Wall of a tube, fine enough for surfaces at the distance `wall_gap` (r0) from it or more.

    The velocity on the wall that a source at that distance gives has modes that fall as
    exp(-k wall_gap), and so does their effect back there; both are resolved to `tolerance`.
    """
    exponent = -math.log(tolerance)
    largest = exponent / (1.4 * wall_gap)
    # A polynomial takes sqrt(k R log(amplitude/error)) nodes for exp(k (r - R)), and amplitudes are
    # exp(-k wall_gap): it takes most at k = log(1/tolerance)/(2 wall_gap).
    most = 0.5 * exponent * math.sqrt(radius / wall_gap)
    angles = _node_angles(math.ceil(MARGIN * most) + MORE)
    depths = radius * np.sin(0.5 * angles) ** 2
    halvings = np.log2(np.maximum(0.5 * (1.0 + depths / wall_gap), 1.0)).astype(int)
    layers = [(largest / 2**each, angles[halvings == each]) for each in np.unique(halvings)]
    return TubeWall(
        tolerance=tolerance,
        radius=constant(float(radius)),
        period=constant(float(period)),
        response=tuple(constant(_responses(radius, period, *each)) for each in layers),
    )


def _responses(
    radius: float, period: float, largest: float, angles: np.ndarray
) -> Float[np.ndarray, "3 3 node m k"]:
    """The radial functions at nodes of some angles, of all modes with k >= 0 up to the largest.

    Those of -m follow from those of m, as a component changes its sign.
    """
    orders = math.ceil(largest * radius)
    waves = math.ceil(largest * period / (2.0 * math.pi))
    nodes = radius * np.cos(0.5 * angles) ** 2
    k = 2.0 * np.pi * np.arange(1, waves + 1) / period
    response = np.empty((3, 3, nodes.size, 2 * orders + 1, waves + 1))
    turned = np.array([1.0, -1.0, 1.0])
    signs = np.outer(turned, turned)[..., None, None]
    for m in range(orders + 1):
        uniform = _uniform_response(m, radius, nodes)
        values = np.concatenate([uniform[None], _axial_response(m, k, radius, nodes)])
        found = np.moveaxis(values, 0, -1)
        response[..., orders - m, :] = signs * found
        response[..., orders + m, :] = found
    return response
