"""Shaded polygons in a two-dimensional picture: farthest first, each lit by its own normal.

A painter's algorithm with full control of light and depth; Matplotlib's own three-dimensional axes
light flat faces only and cannot be drawn with perspective and equal aspect at the same time.
"""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Int
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection

from celltrain.pictures.camera import Camera

BLOOD = np.array([0.80, 0.085, 0.07])


def _unit(vector: tuple[float, float, float]) -> Float[np.ndarray, "3"]:
    array = np.asarray(vector)
    return array / np.linalg.norm(array)


@dataclass(frozen=True)
class Light:
    """Blinn-Phong lighting by a key and a weak fill light (Blinn, SIGGRAPH 1977).

    Directions are (right, up, towards the eye) in the picture, so that the light moves with the
    camera.
    """

    key: Float[np.ndarray, "3"] = field(default_factory=lambda: _unit((-0.25, 0.72, 0.68)))
    fill: Float[np.ndarray, "3"] = field(default_factory=lambda: _unit((0.8, -0.35, 0.45)))
    ambient: float = 0.30
    diffuse: float = 0.72
    fill_strength: float = 0.25
    gloss: float = 0.34
    shininess: float = 20.0
    rim: float = 0.35

    def shade(
        self,
        points: Float[np.ndarray, "face 3"],
        normals: Float[np.ndarray, "face 3"],
        color: Float[np.ndarray, "3"],
        camera: Camera,
    ) -> Float[np.ndarray, "face 3"]:
        """Colours (red, green, blue in 0 ... 1) of faces with the given normals."""
        frame = np.stack([camera.right, camera.up, camera.backward])
        key, fill = self.key @ frame, self.fill @ frame
        view = camera.eye - points
        view /= np.linalg.norm(view, axis=-1, keepdims=True)
        half = view + key
        half /= np.linalg.norm(half, axis=-1, keepdims=True)
        # The key light reaches a little around the edge, as a large lamp does.
        wrapped = np.clip((normals @ key + 0.25) / 1.25, 0.0, 1.0)
        matt = (
            self.ambient
            + self.diffuse * wrapped
            + self.fill_strength * np.clip(normals @ fill, 0.0, 1.0)
        )
        glint = self.gloss * np.clip((normals * half).sum(-1), 0.0, 1.0) ** self.shininess
        edge = self.rim * (1.0 - np.clip((normals * view).sum(-1), 0.0, 1.0)) ** 3
        lit = color * matt[:, None] * (1.0 - edge[:, None]) + glint[:, None]
        # The eye sees square roots of intensities, roughly: lift the dark side without washing out.
        return np.clip(lit, 0.0, 1.0) ** 0.85


def draw_surfaces(
    axes: Axes,
    camera: Camera,
    vertices: Float[np.ndarray, "cell vertex 3"],
    normals: Float[np.ndarray, "cell vertex 3"],
    faces: Int[np.ndarray, "face 4"],
    *,
    color: Float[np.ndarray, "3"] = BLOOD,
    light: Light | None = None,
    zorder: float = 2.0,
) -> PolyCollection:
    """Draw closed opaque surfaces; only faces turned to the eye are drawn, farthest first."""
    light = light or Light()
    flat, depth = camera.project(vertices)
    corners = flat[:, faces].reshape(-1, 4, 2)
    centre_depth = depth[:, faces].mean(axis=-1).ravel()
    # Twice the signed area, by the diagonals: positive when seen from outside.
    first, second = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    facing = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0] > 0
    order = np.flatnonzero(facing)
    order = order[np.argsort(centre_depth[order], kind="stable")]

    normal = normals[:, faces].mean(axis=2).reshape(-1, 3)[order]
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    centre = vertices[:, faces].mean(axis=2).reshape(-1, 3)[order]
    colors = light.shade(centre, normal, color, camera)
    # A hair of edge in the face's own colour closes the seams that antialiasing leaves.
    polygons = PolyCollection(
        list(corners[order]), facecolors=colors, edgecolors=colors, linewidths=0.35, zorder=zorder
    )
    axes.add_collection(polygons, autolim=False)
    return polygons
