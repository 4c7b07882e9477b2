"""How far, and turned which way about the axis, a linear disturbance is drawn.

A linear mode has no amplitude of its own, and on an axisymmetric train a mode with m > 0 may be
turned freely about the axis. Both are chosen here so that the picture shows most.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.spatial import cKDTree

from celltrain.harmonics import degree_of
from celltrain.pictures.camera import Camera
from celltrain.pictures.surface import surface

# Largest displacement drawn (r0): half a cell radius is seen at a glance.
DISPLACEMENT = 0.5


@dataclass(frozen=True)
class Drawn:
    """A disturbance as drawn: `coefficients = base + amplitude * disturbance`, then turned.

    Attributes:
        coefficients: shape coefficients of every cell (r0), axial shift not included.
        amplitude: factor on the disturbance as given.
        displacement: the largest surface displacement that it causes (r0).
        angle: turn about the tube's axis (radians).
    """

    coefficients: Float[np.ndarray, "cell 3 coefficient"]
    amplitude: float
    displacement: float
    angle: float


def turned(
    coefficients: Float[np.ndarray, "*cell 3 coefficient"], angle: float
) -> Float[np.ndarray, "*cell 3 coefficient"]:
    """The same shapes, turned by `angle` (radians) about the tube's axis as rigid bodies."""
    cosine, sine = np.cos(angle), np.sin(angle)
    rotation = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    return np.einsum("ij,...jc->...ic", rotation, coefficients)


def draw_amplitude(
    base: Float[np.ndarray, "3 coefficient"],
    disturbance: Float[np.ndarray, "cell 3 coefficient"],
    *,
    period: float,
    radius: float,
    camera: Camera,
    displacement: float = DISPLACEMENT,
) -> Drawn:
    """Choose amplitude and turn so that the disturbance is plain to see and cells stay apart.

    Starts from the given largest displacement (r0) and lessens it by tenths: to two fifths at most
    while the surface folds over, and to a fifth at most while a cell enters another or the wall.

    Raises:
        ValueError: if the disturbance moves nothing.
    """
    mesh = surface(degree_of(base), 24, 36)
    rest = mesh.vertices(base)
    moved = mesh.vertices(disturbance)
    normals = mesh.normals(rest)
    largest = float(np.linalg.norm(moved, axis=-1).max())
    if largest == 0.0:
        raise ValueError("a disturbance that moves nothing cannot be drawn")

    full = amplitude = displacement / largest
    allowed = 0.5 * min(_clearance(rest[None], normals[None], period, radius), 0.1)
    while amplitude > 0.4 * full and _folds(mesh.normals(rest + amplitude * moved), normals):
        amplitude *= 0.9
    while amplitude > 0.2 * full:
        shape = rest + amplitude * moved
        if _clearance(shape, mesh.normals(shape), period, radius) >= allowed:
            break
        amplitude *= 0.9
    angle = _best_turn(moved, normals, camera)
    coefficients = turned(base + amplitude * disturbance, angle)
    return Drawn(coefficients, amplitude, amplitude * largest, angle)


def _folds(
    tilted: Float[np.ndarray, "cell vertex 3"], normals: Float[np.ndarray, "vertex 3"]
) -> bool:
    """Whether more than a few parts in a hundred of a surface face backwards."""
    return bool(((tilted * normals).sum(-1) < 0.0).mean(axis=-1).max() > 0.03)


def _clearance(
    vertices: Float[np.ndarray, "cell vertex 3"],
    normals: Float[np.ndarray, "cell vertex 3"],
    period: float,
    radius: float,
) -> float:
    """Smallest distance (r0) from cell to next cell and to the wall; negative if they overlap."""
    wall = radius - float(np.hypot(vertices[..., 0], vertices[..., 1]).max())
    smallest = wall
    for cell in range(len(vertices)):
        following = (cell + 1) % len(vertices)
        ahead = vertices[following] + [0.0, 0.0, period]
        distance, nearest = cKDTree(ahead).query(vertices[cell])
        offset = vertices[cell] - ahead[nearest]
        # Every overlap has a shallow part, where the nearest vertex's normal can be trusted.
        along = (offset * normals[following][nearest]).sum(-1)
        inside = (along < -0.7 * distance) & (distance < 0.3)
        smallest = min(smallest, float(np.where(inside, -distance, distance).min()))
    return smallest


def _best_turn(
    moved: Float[np.ndarray, "cell vertex 3"],
    normals: Float[np.ndarray, "vertex 3"],
    camera: Camera,
) -> float:
    """The turn (radians) that moves the outlines of the cells, as seen in the picture, most."""
    outward = (moved * normals).sum(-1)
    seen = []
    angles = np.linspace(0.0, np.pi, 36, endpoint=False)
    for angle in angles:
        # Turning the cells by an angle is turning the eye by its opposite.
        eye = turned(camera.backward[:, None], -angle)[:, 0]
        outline = (1.0 - (normals @ eye) ** 2) ** 6
        seen.append(float((outline * outward**2).sum()))
    best = max(seen)
    return float(angles[next(i for i, value in enumerate(seen) if value >= 0.999 * best)])
