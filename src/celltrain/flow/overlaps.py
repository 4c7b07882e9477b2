"""Which cells overlap, or stick out of the tube: a check on shapes, outside compiled programs."""

from dataclasses import dataclass
from functools import cache

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from scipy.spatial import KDTree

from celltrain.flow.nearest import NearestPoint, nearest_point
from celltrain.harmonics import Shape, Shapes, degree_of
from celltrain.harmonics.grid import sphere_grid
from celltrain.harmonics.jax_shapes import JaxShape, JaxShapes
from celltrain.harmonics.tables import harmonic_tables

BATCH = 128


@dataclass(frozen=True)
class Overlap:
    """A cell that overlaps another one, or the wall.

    `second` is displaced by `image` periods; it is None for the wall. `point` is that of all grid
    points of either cell which is deepest inside the other (or the wall), seen from `first`, and
    `depth` how deep, both in r0.
    """

    first: int
    second: int | None
    image: int
    point: Float[np.ndarray, "3"]
    depth: float

    def __str__(self) -> str:
        where = "x = {:.3f}, y = {:.3f}, z = {:.3f}".format(*self.point)
        if self.second is None:
            return f"cell {self.first} reaches {self.depth:.2g} r0 into the wall at {where}"
        other = f"cell {self.second}"
        if self.image:
            other += f" displaced by {self.image} period{'s' if abs(self.image) > 1 else ''}"
        return f"cell {self.first} and {other} overlap by {self.depth:.2g} r0 at {where}"


@dataclass(frozen=True)
class _Surface:
    """Grid points of a cell, their outward normals, their bounding box, and a tree of them."""

    shape: Shape
    points: Float[np.ndarray, "point 3"]
    normals: Float[np.ndarray, "point 3"]
    low: Float[np.ndarray, "3"]
    high: Float[np.ndarray, "3"]
    tree: KDTree


def overlaps(
    shapes: Shapes | JaxShapes,
    *,
    period: float,
    images: int = 1,
    radius: float | None = None,
    order: int | None = None,
) -> tuple[Overlap, ...]:
    """All pairs of cells (and periodic images) that intersect, and cells beyond the wall.

    The grid points of each cell are tested by their signed distances from the other one, so what is
    found is at least as deep as the sag of the surface between grid points. That a cell meets
    itself is not looked for.

    **Arguments:** `period`: length of the train, in r0; `images`: how many of them are looked at to
    each side; `radius`: of the tube, if the wall is to be looked at; `order`: of the grid (three
    times the degree unless given).
    """
    shapes = np.asarray(shapes)
    degree = degree_of(shapes)
    guesses, (value, d_theta, d_phi), method = _tools(
        degree, 3 * degree if order is None else order
    )
    surfaces = []
    for shape in shapes:
        points = value @ shape.T
        normals = np.cross(d_theta @ shape.T, d_phi @ shape.T)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        low, high = points.min(axis=0), points.max(axis=0)
        surfaces.append(_Surface(shape, points, normals, low, high, KDTree(points)))
    found = []
    if radius is not None:
        for number, surface in enumerate(surfaces):
            distance = np.hypot(surface.points[:, 0], surface.points[:, 1])
            far = int(np.argmax(distance))
            if distance[far] > radius:
                depth = float(distance[far] - radius)
                found.append(Overlap(number, None, 0, surface.points[far], depth))
    for first, one in enumerate(surfaces):
        for second, other in enumerate(surfaces[first:], start=first):
            for image in range(1 if first == second else -images, images + 1):
                shift = np.array([0.0, 0.0, image * period])
                there, here = (
                    _deepest(method, other, one.points - shift, guesses),
                    _deepest(method, one, other.points + shift, guesses),
                )
                depth, point = max((there[0], there[1] + shift), here, key=lambda each: each[0])
                if depth > 0.0:
                    found.append(Overlap(first, second, image, point, depth))
    return tuple(found)


@cache
def _tools(degree: int, order: int) -> tuple[np.ndarray, tuple[np.ndarray, ...], NearestPoint]:
    """Points of a grid [point, 2]; values and slopes of the harmonics there; Newton's method."""
    theta, phi = sphere_grid(degree, order).points()
    tables = harmonic_tables(degree, theta, phi)
    harmonics = tuple(np.asarray(each) for each in (tables.value, tables.d_theta, tables.d_phi))
    return np.stack([theta, phi], axis=-1), harmonics, nearest_point(degree)


def _deepest(
    method: NearestPoint,
    surface: _Surface,
    points: Float[np.ndarray, "point 3"],
    guesses: Float[np.ndarray, "node 2"],
) -> tuple[float, Float[np.ndarray, "3"]]:
    """Largest depth of the points inside a surface, 0 if none is inside, and that point."""
    low, high = surface.low, surface.high
    # The surface may pass the bounding box of its grid points by their sag.
    margin = 0.05 * (high - low).max()
    points = points[((points > low - margin) & (points < high + margin)).all(axis=1)]
    if not points.size:
        return 0.0, low
    distance, node = map(np.asarray, surface.tree.query(points))
    # Points far outside see their nearest node from its front, and need no closer look.
    height = ((points - surface.points[node]) * surface.normals[node]).sum(axis=1)
    maybe = height < 0.5 * distance
    points, node = points[maybe], node[maybe]
    if not points.size:
        return 0.0, low
    signed = np.concatenate(
        [
            _signed_distances(method, surface, points[i : i + BATCH], guesses[node[i : i + BATCH]])
            for i in range(0, len(points), BATCH)
        ]
    )
    deepest = int(np.argmin(signed))
    return max(0.0, -float(signed[deepest])), points[deepest]


def _signed_distances(
    method: NearestPoint,
    surface: _Surface,
    points: Float[np.ndarray, "point 3"],
    guesses: Float[np.ndarray, "point 2"],
) -> Float[np.ndarray, " point"]:
    """Distances from the surface, negative inside; batches of one size, compiled once."""
    padding = ((0, BATCH - len(points)), (0, 0))
    found = _batch(
        method,
        jnp.asarray(np.pad(points, padding, mode="edge")),
        jnp.asarray(surface.shape),
        jnp.asarray(np.pad(guesses, padding, mode="edge")),
    )
    return np.asarray(found)[: len(points)]


@eqx.filter_jit
def _batch(
    method: NearestPoint,
    points: Float[Array, "point 3"],
    shape: JaxShape,
    guesses: Float[Array, "point 2"],
) -> Float[Array, " point"]:
    shapes = jnp.broadcast_to(shape, (points.shape[0], *shape.shape))
    return method(points, shapes, guesses).distance
