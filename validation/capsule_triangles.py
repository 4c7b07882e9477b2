"""A neo-Hookean capsule in shear by a second method, which shares nothing with the package's.

The membrane is a net of flat triangles, each of a constant strain, whose nodes carry the
derivatives of the energy; the velocity is the single layer of that force, linear on triangles,
integrated by Gauss' rules and, on triangles about the point itself, by Duffy's. Nodes move with the
fluid, by Heun's method with fixed steps. All of it is of second order in the triangles' size, so
that three nets give a limit and its error.

Viscosities in and out are 1, the shear rate is 1, and so is the radius at rest.
"""

from dataclasses import dataclass

import numba
import numpy as np

# Gauss' rules on a triangle, as rows of barycentric coordinates and a weight: of degree 2 and 5.
_FAR = np.array([[4, 1, 1, 2], [1, 4, 1, 2], [1, 1, 4, 2]]) / 6.0
_ROOT = np.sqrt(15.0)
_NEAR = np.array(
    [[1 / 3, 1 / 3, 1 / 3, 9 / 40]]
    + [
        [*np.roll([1 - 2 * each, each, each], turn), weight]
        for each, weight in (
            ((6 - _ROOT) / 21, (155 - _ROOT) / 1200),
            ((6 + _ROOT) / 21, (155 + _ROOT) / 1200),
        )
        for turn in range(3)
    ]
)
# A triangle is near within so many times the longest edge.
_NEAR_EDGES = 2.5


def duffy(order: int) -> np.ndarray:
    """Duffy's rule on a triangle for what is singular as 1/r at its first corner."""
    nodes, weights = np.polynomial.legendre.leggauss(order)
    u, w = 0.5 * (nodes + 1.0), 0.5 * weights
    a, b = np.meshgrid(u, u, indexing="ij")
    rows = [1.0 - a, a * (1.0 - b), a * b, 2.0 * a * np.outer(w, w)]
    return np.stack([row.ravel() for row in rows], axis=1)


_DUFFY = duffy(6)


@dataclass(frozen=True)
class Net:
    """A sphere's nodes [node, 3] and triangles [triangle, 3], corners counter-clockwise."""

    nodes: np.ndarray
    triangles: np.ndarray

    @classmethod
    def icosahedron(cls) -> "Net":
        """20 triangles."""
        golden = 0.5 * (1.0 + np.sqrt(5.0))
        flat = np.array([[0.0, s, t * golden] for s in (1, -1) for t in (1, -1)])
        nodes = np.concatenate([np.roll(flat, turn, axis=1) for turn in range(3)])
        distances = np.linalg.norm(nodes[:, None] - nodes, axis=2)
        near = np.isclose(distances, 2.0)
        found = [
            (i, j, k)
            for i in range(12)
            for j in range(12)
            for k in range(12)
            if i < j and i < k and near[i, j] and near[j, k] and near[k, i]
            if np.linalg.det(nodes[[i, j, k]]) > 0.0
        ]
        return cls(nodes / np.linalg.norm(nodes[0]), np.array(found))

    def split(self, parts: int) -> "Net":
        """Each of the triangles in parts^2, and nodes back on the sphere."""
        places: dict[tuple[float, ...], int] = {}
        nodes: list[np.ndarray] = []

        def number(point: np.ndarray) -> int:
            point = point / np.linalg.norm(point)
            key = tuple(np.round(point, 9) + 0.0)
            if key not in places:
                places[key] = len(nodes)
                nodes.append(point)
            return places[key]

        triangles = []
        for a, b, c in self.nodes[self.triangles]:
            at = {
                (i, j): number(a + (b - a) * i / parts + (c - a) * j / parts)
                for i in range(parts + 1)
                for j in range(parts + 1 - i)
            }
            for i, j in at:
                if i + j < parts:
                    triangles.append((at[i, j], at[i + 1, j], at[i, j + 1]))
                if i + j < parts - 1:
                    triangles.append((at[i + 1, j], at[i + 1, j + 1], at[i, j + 1]))
        return Net(np.array(nodes), np.array(triangles))


class Capsule:
    """The forces of the membrane, free of stress on the sphere, and the velocities of the nodes."""

    def __init__(self, net: Net, shear_modulus: float) -> None:
        self.triangles, self.modulus = net.triangles, shear_modulus
        edges = self._edges(net.nodes)
        along = edges[:, :, 0] / np.linalg.norm(edges[:, :, 0], axis=1)[:, None]
        across = np.cross(np.cross(edges[:, :, 0], edges[:, :, 1]), along)
        across /= np.linalg.norm(across, axis=1)[:, None]
        flat = np.stack([along, across], axis=1) @ edges
        self.inverse = np.linalg.inv(flat)
        self.area = 0.5 * np.linalg.det(flat)

    def _edges(self, nodes: np.ndarray) -> np.ndarray:
        """Two edges of each triangle, [triangle, 3, 2]."""
        a, b, c = (nodes[self.triangles[:, each]] for each in range(3))
        return np.stack([b - a, c - a], axis=2)

    def energy(self, nodes: np.ndarray) -> float:
        """sum A_0 Gs/2 (l1^2 + l2^2 + 1/(l1 l2)^2 - 3)."""
        strain = self._edges(nodes) @ self.inverse
        cauchy = strain.transpose(0, 2, 1) @ strain
        trace, determinant = np.trace(cauchy, axis1=1, axis2=2), np.linalg.det(cauchy)
        density = 0.5 * self.modulus * (trace + 1.0 / determinant - 3.0)
        return float(self.area @ density)

    def forces(self, nodes: np.ndarray) -> np.ndarray:
        """Minus the energy's derivatives, at the nodes."""
        strain = self._edges(nodes) @ self.inverse
        cauchy = strain.transpose(0, 2, 1) @ strain
        determinant = np.linalg.det(cauchy)[:, None, None]
        stress = self.modulus * (strain - strain @ np.linalg.inv(cauchy) / determinant)
        pulls = self.area[:, None, None] * (stress @ self.inverse.transpose(0, 2, 1))
        found = np.zeros_like(nodes)
        for corner, pull in ((1, pulls[:, :, 0]), (2, pulls[:, :, 1])):
            np.add.at(found, self.triangles[:, corner], -pull)
            np.add.at(found, self.triangles[:, 0], pull)
        return found

    def velocities(self, nodes: np.ndarray) -> np.ndarray:
        """Shear y e_x, and what the membrane adds."""
        edges = self._edges(nodes)
        areas = 0.5 * np.linalg.norm(np.cross(edges[:, :, 0], edges[:, :, 1]), axis=1)
        shares = np.zeros(len(nodes))
        for corner in range(3):
            np.add.at(shares, self.triangles[:, corner], areas / 3.0)
        density = self.forces(nodes) / shares[:, None]
        near = _NEAR_EDGES * np.linalg.norm(edges, axis=1).max()
        found = _single_layer(nodes, self.triangles, areas, density, near)
        found[:, 0] += nodes[:, 1]
        return found

    def moments(self, nodes: np.ndarray) -> tuple[float, np.ndarray]:
        """Volume, and the second moments over it, of the polyhedron about 0."""
        a, b, c = (nodes[self.triangles[:, each]] for each in range(3))
        volumes = np.einsum("ti,ti->t", a, np.cross(b, c)) / 6.0
        middle = a + b + c
        second = sum(np.einsum("t,ti,tj->ij", volumes, p, p) for p in (a, b, c, middle)) / 20.0
        return float(volumes.sum()), second / volumes.sum()

    def deformation(self, nodes: np.ndarray) -> float:
        """Taylor's D of the ellipsoid with these moments."""
        short, _, long = np.sqrt(np.linalg.eigvalsh(self.moments(nodes)[1]))
        return float((long - short) / (long + short))


@numba.njit(fastmath=True)  # type: ignore[misc]
def _single_layer(nodes, triangles, areas, density, near):  # type: ignore[no-untyped-def]
    """1/(8 pi) times the integral of (1/r + r r/r^3) f at the nodes."""
    found = np.zeros_like(nodes)
    order = np.empty(3, np.int64)
    for target in range(len(nodes)):
        x0, x1, x2 = nodes[target]
        sum0 = sum1 = sum2 = 0.0
        for triangle in range(len(triangles)):
            own = -1
            for corner in range(3):
                if triangles[triangle, corner] == target:
                    own = corner
            for corner in range(3):
                order[corner] = triangles[triangle, (corner + max(own, 0)) % 3]
            i, j, k = order
            if own >= 0:
                rule = _DUFFY
            else:
                distance = 0.0
                for axis in range(3):
                    middle = (nodes[i, axis] + nodes[j, axis] + nodes[k, axis]) / 3.0
                    distance += (middle - nodes[target, axis]) ** 2
                rule = _NEAR if distance < near * near else _FAR
            for row in range(len(rule)):
                p, q, s = rule[row, 0], rule[row, 1], rule[row, 2]
                d0 = x0 - (p * nodes[i, 0] + q * nodes[j, 0] + s * nodes[k, 0])
                d1 = x1 - (p * nodes[i, 1] + q * nodes[j, 1] + s * nodes[k, 1])
                d2 = x2 - (p * nodes[i, 2] + q * nodes[j, 2] + s * nodes[k, 2])
                f0 = p * density[i, 0] + q * density[j, 0] + s * density[k, 0]
                f1 = p * density[i, 1] + q * density[j, 1] + s * density[k, 1]
                f2 = p * density[i, 2] + q * density[j, 2] + s * density[k, 2]
                inverse = 1.0 / np.sqrt(d0 * d0 + d1 * d1 + d2 * d2)
                weight = rule[row, 3] * areas[triangle] * inverse
                along = (d0 * f0 + d1 * f1 + d2 * f2) * inverse * inverse
                sum0 += weight * (f0 + along * d0)
                sum1 += weight * (f1 + along * d1)
                sum2 += weight * (f2 + along * d2)
        found[target, 0], found[target, 1], found[target, 2] = sum0, sum1, sum2
    return found / (8.0 * np.pi)


def march(parts: int, strength: float, until: float, step: float) -> np.ndarray:
    """Rows of k t and D, from the sphere: mu k a/Gs = strength, 20 parts^2 triangles."""
    net = Net.icosahedron().split(parts)
    capsule, nodes = Capsule(net, 1.0 / strength), net.nodes
    rows = [(0.0, capsule.deformation(nodes))]
    for count in range(1, round(until / step) + 1):
        first = capsule.velocities(nodes)
        second = capsule.velocities(nodes + step * first)
        nodes = nodes + 0.5 * step * (first + second)
        rows.append((count * step, capsule.deformation(nodes)))
    return np.array(rows)
