"""The tube as a glass cylinder: a far wall behind the cells and a faint near wall before them."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection

from celltrain.parameters import Train
from celltrain.pictures.camera import Camera

GLASS = np.array([0.40, 0.54, 0.66])
OUTLINE = (0.25, 0.33, 0.40)
STRIPS = 180


@dataclass(frozen=True)
class TubeView:
    """A part of the tube, as it is seen from the side.

    Attributes:
        radius: of the tube, r0.
        start, end: axial positions between which it is drawn, r0.
        camera: the eye.
    """

    radius: float
    start: float
    end: float
    camera: Camera

    def limits(self, lowest: float = np.inf) -> Float[np.ndarray, "2 2"]:
        """Least and largest coordinates of the picture, `lowest` in it, with a margin."""
        rings = self.radius * _circle(60) + [[[0.0, 0.0, z]] for z in (self.start, self.end)]
        flat = self.camera.project(rings)[0].reshape(-1, 2)
        low, high = flat.min(axis=0), flat.max(axis=0)
        low[1] = min(low[1], lowest)
        margin = 0.02 * (high[0] - low[0])
        return np.stack([low - margin, high + margin])

    def draw(self, axes: Axes, lowest: float = np.inf) -> None:
        """Draw it around whatever has zorder 2, into axes that show nothing else."""
        axes.set_axis_off()
        axes.set_aspect("equal")
        (left, bottom), (right, top) = self.limits(lowest)
        axes.set(xlim=(left, right), ylim=(bottom, top))
        normal = _circle(STRIPS + 1)
        inlet, outlet = (self.radius * normal + [0.0, 0.0, z] for z in (self.start, self.end))
        view = self.camera.eye - (inlet + outlet) / 2
        view /= np.linalg.norm(view, axis=-1, keepdims=True)
        facing = (normal * view).sum(-1)
        flat = np.stack([self.camera.project(inlet)[0], self.camera.project(outlet)[0]])
        # Start where the cylinder turns from facing away to facing the eye: near half first.
        turn = int(np.flatnonzero((facing[:-1] <= 0) & (facing[1:] > 0))[0])
        order = np.append(np.roll(np.arange(STRIPS), -turn), turn)
        flat, facing = flat[:, order], facing[order]
        half = int(np.flatnonzero(facing > 0)[-1]) + 1

        _far_wall(axes, flat[:, half - 1 :], facing[half - 1 :])
        _near_wall(axes, flat[:, : half + 1], facing[: half + 1])
        for place in (0, half):
            axes.plot(*flat[:, place].T, color=OUTLINE, linewidth=1.0, zorder=3.2)
        # The eye is upstream: it sees the whole inlet, and half of the outlet behind the cells.
        axes.plot(*flat[0].T, color=OUTLINE, linewidth=1.0, zorder=3.2)
        axes.plot(*flat[1, : half + 1].T, color=OUTLINE, linewidth=1.0, zorder=3.2)
        axes.plot(*flat[1, half:].T, color=OUTLINE, linewidth=0.6, zorder=1.2)


def tube_view(train: Train, start: float, length: float) -> TubeView:
    """So much of a train's tube, r0; flatter if long: perspective would shrink its end too much."""
    middle = np.array([0.0, 0.0, start + 0.5 * length])
    camera = Camera(middle, 2.6 * length + 3.0 * train.tube.diameter)
    return TubeView(train.radius, start, start + length, camera)


def _circle(points: int) -> Float[np.ndarray, "point 3"]:
    angle = np.linspace(0.0, 2 * np.pi, points)
    return np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1)


def _grazing(facing: Float[np.ndarray, "edge"]) -> Float[np.ndarray, "edge"]:
    """How much denser glass looks where one looks along the wall, 0 to 1."""
    return (1.0 - np.clip(np.abs(facing), 0.0, 1.0)) ** 2.5


def _far_wall(
    axes: Axes, flat: Float[np.ndarray, "2 edge 2"], facing: Float[np.ndarray, "edge"]
) -> None:
    """Opaque strips on white paper, so that their seams cannot show."""
    density = 0.11 + 0.34 * _grazing((facing[1:] + facing[:-1]) / 2)
    colors = 1.0 - density[:, None] * (1.0 - GLASS)
    corners = np.stack([flat[0, :-1], flat[0, 1:], flat[1, 1:], flat[1, :-1]], axis=1)
    axes.add_collection(
        PolyCollection(
            list(corners), facecolors=colors, edgecolors=colors, linewidths=0.5, zorder=1.0
        ),
        autolim=False,
    )


def _near_wall(
    axes: Axes, flat: Float[np.ndarray, "2 edge 2"], facing: Float[np.ndarray, "edge"]
) -> None:
    """Translucent glass, densest at its edges.

    Side by side, translucent strips would show their seams; instead many layers reach from an edge
    to different widths and add up.
    """
    layers = 8
    grazing = _grazing(facing)
    polygons = []
    for level in (np.arange(layers) + 0.5) / layers:
        dense = grazing > level
        first = int(np.argmin(dense))
        last = len(dense) - 1 - int(np.argmin(dense[::-1]))
        for part in (slice(0, first + 1), slice(last, None)):
            polygons.append(np.concatenate([flat[0, part], flat[1, part][::-1]]))
    whole = np.concatenate([flat[0], flat[1][::-1]])
    for shapes, alpha, zorder in ((polygons, 0.03, 3.0), ([whole], 0.03, 3.1)):
        axes.add_collection(
            PolyCollection(
                shapes, facecolors=(*GLASS, alpha), edgecolors="none", linewidths=0, zorder=zorder
            ),
            autolim=False,
        )
