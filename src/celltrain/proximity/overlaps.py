"""Which cells overlap, cross themselves, or stick out of the tube: a check on given shapes."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from jaxtyping import Float
from scipy.spatial import KDTree

from celltrain.harmonics import Shape, Shapes, degree_of, surface_points
from celltrain.harmonics.grid import sphere_grid
from celltrain.harmonics.jax_shapes import JaxShapes
from celltrain.harmonics.tables import harmonic_tables
from celltrain.proximity.boxes import close_boxes, image_shift
from celltrain.proximity.film_points import film_grid
from celltrain.proximity.nearest import nearest_points
from celltrain.proximity.walls import NoWall, Wall

# How far a surface may pass the bounding box of its grid points, over the box's largest side.
SAG = 0.05
NO_WALL = NoWall()
# Distance of two parts of one membrane within which it is asked whether they cross, r0: where they
# have just done so they are closer than that.
FACING = 0.05


@dataclass(frozen=True)
class Overlap:
    """A cell that overlaps another one, or the wall, or crosses itself.

    `second` is displaced by `image` periods; it is None for the wall, and `first`, not displaced,
    where two parts of one membrane cross. `point` is that of all grid points of either cell which
    is deepest inside the other (or the wall), seen from `first`, and `depth` how deep, both in r0;
    of parts that cross, only those closer to each other than `FACING` are asked.
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
        if self.second == self.first and not self.image:
            return f"two parts of cell {self.first} cross at {where}"
        other = f"cell {self.second}"
        if self.image:
            other += f" displaced by {self.image} period{'s' if abs(self.image) > 1 else ''}"
        return f"cell {self.first} and {other} overlap by {self.depth:.2g} r0 at {where}"


@dataclass(frozen=True)
class _Tools:
    """Points of a grid, and values and slopes of the harmonics there."""

    angles: Float[np.ndarray, "point 2"]
    values: Float[np.ndarray, "point coefficient"]
    slopes: tuple[Float[np.ndarray, "point coefficient"], Float[np.ndarray, "point coefficient"]]


@dataclass(frozen=True)
class _Surface:
    """Grid points of a cell, their outward normals, and a tree of them."""

    shape: Shape
    points: Float[np.ndarray, "point 3"]
    normals: Float[np.ndarray, "point 3"]
    tree: KDTree


def overlaps(
    shapes: Shapes | JaxShapes,
    *,
    period: float,
    images: int = 1,
    wall: Wall = NO_WALL,
    order: int | None = None,
) -> tuple[Overlap, ...]:
    """All pairs of cells (and images) that intersect, cells beyond the wall or across themselves.

    The grid points of each cell are tested by their signed distances from the other one, so what is
    found is at least as deep as the sag of the surface between grid points.

    **Arguments:** `period`: length of the train, in r0, infinite if nothing recurs; `images`: how
    many of them are looked at to each side; `wall`: which is to be looked at, none unless given;
    `order`: of the grid (three times the degree unless given).
    """
    shapes = np.asarray(shapes)
    degree = degree_of(shapes)
    tools = _tools(degree, 3 * degree if order is None else order)
    points = surface_points(shapes, tools.values)
    found = _beyond_wall(points, wall) + _across_themselves(shapes)
    margin = SAG * float(np.ptp(points, axis=1).max())
    surfaces: dict[int, _Surface] = {}
    for first, second, image in close_boxes(points, within=margin, period=period, images=images):
        for cell in {first, second} - surfaces.keys():
            surfaces[cell] = _surface(tools, shapes[cell], points[cell])
        one, other = surfaces[first], surfaces[second]
        shift = image_shift(image, period)
        there, here = (
            _deepest(tools, other, one.points - shift),
            _deepest(tools, one, other.points + shift),
        )
        depth, point = max((there[0], there[1] + shift), here, key=lambda each: each[0])
        if depth > 0.0:
            found.append(Overlap(first, second, image, point, depth))
    return tuple(found)


def _beyond_wall(points: Float[np.ndarray, "cell point 3"], wall: Wall) -> list[Overlap]:
    """Cells with points beyond the wall."""
    depth = -wall.distance(points)
    deepest = np.argmax(depth, axis=1)
    depths = depth[np.arange(len(points)), deepest]
    return [
        Overlap(cell, None, 0, points[cell, deepest[cell]], float(depth))
        for cell, depth in enumerate(depths)
        if depth > 0.0
    ]


def _across_themselves(shapes: Shapes) -> list[Overlap]:
    """Cells of which two parts have crossed."""
    grid = film_grid(degree_of(shapes))
    found = []
    for cell, sides in grid.own_sides.find(shapes, grid.coarse.surfaces(shapes), within=FACING):
        deepest = int(np.argmin(sides.gap))
        depth = -float(sides.gap[deepest])
        if depth > 0.0:
            found.append(Overlap(cell, cell, 0, sides.place[deepest], depth))
    return found


@cache
def _tools(degree: int, order: int) -> _Tools:
    theta, phi = sphere_grid(degree, order).points()
    tables = harmonic_tables(degree, theta, phi)
    return _Tools(
        angles=np.stack([theta, phi], axis=-1),
        values=np.asarray(tables.value),
        slopes=(np.asarray(tables.d_theta), np.asarray(tables.d_phi)),
    )


def _surface(tools: _Tools, shape: Shape, points: Float[np.ndarray, "point 3"]) -> _Surface:
    down, around = (surface_points(shape, each) for each in tools.slopes)
    normals = np.cross(down, around)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return _Surface(shape, points, normals, KDTree(points))


def _deepest(
    tools: _Tools, surface: _Surface, points: Float[np.ndarray, "point 3"]
) -> tuple[float, Float[np.ndarray, "3"]]:
    """Largest depth of the points inside a surface, 0 if none is inside, and that point."""
    low, high = surface.points.min(axis=0), surface.points.max(axis=0)
    margin = SAG * (high - low).max()
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
    cells = np.zeros(len(points), dtype=int)
    guesses = tools.angles[node]
    _, signed = nearest_points(points, cells, surface.shape[None], guesses)
    deepest = int(np.argmin(signed))
    return max(0.0, -float(signed[deepest])), points[deepest]
