"""Pictures of a simulation: how a disturbance grows (Fig. 4), and the cells at chosen times.

The input is plain arrays, wherever they come from.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from celltrain.harmonics import Shapes, degree_of, displaced_along, mean_points
from celltrain.parameters import CaseError, Train
from celltrain.pictures.render import draw_surfaces
from celltrain.pictures.style import BLUE, INK, VERMILION, case_title, in_style
from celltrain.pictures.surface import Mesh, surface
from celltrain.pictures.train import FEWEST_CELLS
from celltrain.pictures.tube import TubeView, tube_view

# Length (r0) of the arrow of the fastest cell.
ARROW = 1.5
# Height over width of a tube's picture above which two of them make a row.
WIDE = 0.4


@dataclass(frozen=True)
class Growth:
    """How the size of a disturbance went, and what linear theory says of it, at the same times.

    Attributes:
        times: r0/U.
        size: eps(t), the norm of the coefficients (Eq. 8), r0.
        displacement: eps_x(t), the norm of the membranes' displacement, r0; or None.
        growth_rate: alpha of exp(alpha t), U/r0; or None.
        linear: |exp(A t) v| in the norm of `size`, r0; or None.
    """

    times: Float[np.ndarray, " time"]
    size: Float[np.ndarray, " _"]
    displacement: Float[np.ndarray, " _"] | None = None
    growth_rate: float | None = None
    linear: Float[np.ndarray, " _"] | None = None


@in_style()
def plot_growth(train: Train, growth: Growth, *, logarithmic_time: bool = False) -> Figure:
    """The size of a disturbance over time, beside its linear predictions.

    Logarithmic in size, as Figs. 4 and 11; exp(alpha t) begins at the first size.

    **Arguments:** `logarithmic_time`: logarithmic in time, too, as Fig. 4, which shows what happens
    at first.

    **Raises:** `CaseError` if fewer than two times or arrays of other lengths are given.
    """
    times, rate = growth.times, growth.growth_rate
    modal = None if rate is None else growth.size[0] * np.exp(rate * (times - times[0]))
    words = "" if rate is None else rf"$e^{{\alpha t}}$, $\alpha$ = {rate:.3g} $U/r_0$"
    curves = [
        (growth.size, BLUE, "-", r"simulation, $\epsilon$"),
        (growth.displacement, VERMILION, "-", r"simulation, $\epsilon_x$"),
        (growth.linear, INK, (0, (5, 2)), r"linear, $|e^{At} v|$"),
        (modal, INK, (0, (1, 1.6)), words),
    ]
    known = [(values, c, line, label) for values, c, line, label in curves if values is not None]
    if len(times) < 2 or any(len(values) != len(times) for values, *_ in known):
        raise CaseError(
            f"{len(times)} times with curves of {[len(values) for values, *_ in known]} values"
            " are not allowed: allowed are two times or more and as many values"
        )
    figure = Figure(figsize=(7.2, 4.6), layout="constrained")
    axes = figure.add_subplot()
    for values, color, line, label in known:
        width = 1.1 if color == INK else 1.8
        axes.plot(times, values, color=color, linestyle=line, linewidth=width, label=label)
    axes.set_yscale("log")
    # What is measured fills the picture; a prediction may leave it.
    seen = np.concatenate([each for each in (growth.size, growth.displacement) if each is not None])
    seen = seen[np.isfinite(seen) & (seen > 0.0)]
    if seen.size:
        axes.set_ylim(0.6 * seen.min(), 2.0 * seen.max())
    if logarithmic_time:
        axes.set_xscale("log")
        axes.set_xlim(times[times > 0.0].min(), times[-1])
    else:
        axes.set_xlim(times[0], times[-1])
    axes.set_xlabel("$t$ ($r_0/U$)")
    axes.set_ylabel("size of the disturbance ($r_0$)")
    axes.set_title(case_title(train))
    axes.legend()
    return figure


@dataclass(frozen=True)
class Scene:
    """The tube, seen from the side, into which cells of any frame are put.

    The window is as long as the train, or as several of its periods if it is short; a cell that
    left it downstream is drawn where its image enters upstream.

    Attributes:
        train: the case.
        cells: number of cells in a period.
        repeats: periods shown.
        tube: as long as these.
        mesh: the mesh of a cell.
    """

    train: Train
    cells: int
    repeats: int
    tube: TubeView
    mesh: Mesh

    @property
    def length(self) -> float:
        """Period of the train, r0."""
        return self.cells * self.train.period

    @property
    def ratio(self) -> float:
        """Height over width of the picture."""
        width, height = np.ptp(self.tube.limits(), axis=0)
        return float(height / width)

    def draw(
        self,
        axes: Axes,
        shapes: Shapes,
        velocities: Float[np.ndarray, "cell 3"] | None = None,
        unit: float = 1.0,
    ) -> None:
        """Draw the tube with the cells of one frame; the first two are called A and B.

        **Arguments:** `velocities`: of each cell (U), drawn as arrows, a velocity of `unit` as long
        as `ARROW`.
        """
        self.tube.draw(axes)
        camera = self.tube.camera
        placed = self.placed(shapes)
        vertices = self.mesh.vertices(placed)
        normals = self.mesh.normals(vertices)
        draw_surfaces(axes, camera, vertices, normals, self.mesh.faces)
        middles = vertices.mean(axis=1)
        if self.cells >= 2:
            for name, cell in zip("AB", vertices[:2], strict=True):
                self._write(axes, name, cell)
        if velocities is not None:
            ends = middles + ARROW / unit * np.tile(velocities, (self.repeats, 1))
            for tail, head in zip(middles, ends, strict=True):
                (first, last), _ = camera.project(np.stack([tail, head]))
                axes.annotate(
                    "",
                    last,
                    first,
                    arrowprops={
                        "arrowstyle": "-|>",
                        "color": "black",
                        "linewidth": 1.1,
                        "shrinkA": 0,
                        "shrinkB": 0,
                        "mutation_scale": 8,
                    },
                    zorder=2.8,
                )

    def _write(self, axes: Axes, name: str, cell: Float[np.ndarray, "vertex 3"]) -> None:
        """Write the name of a cell above it."""
        flat = self.tube.camera.project(cell)[0]
        x, y = 0.5 * (flat[:, 0].min() + flat[:, 0].max()), flat[:, 1].max()
        axes.text(x, y + 0.15, name, color=INK, fontsize=9, ha="center", va="bottom", zorder=4)

    def placed(self, shapes: Shapes) -> Float[np.ndarray, "place 3 coefficient"]:
        """The shapes as they are shown: in the window, and again for every period in it."""
        height = mean_points(shapes)[:, 2]
        back = self.length * np.floor((height - self.tube.start) / self.length)
        repeats = self.length * np.arange(self.repeats)
        moves = (repeats[:, None] - back).ravel()
        return displaced_along(np.tile(shapes, (self.repeats, 1, 1)), moves)


def make_scene(train: Train, shapes: Float[np.ndarray, "time cell 3 coefficient"]) -> Scene:
    """A scene for all of the given frames, whose window begins half a period before a cell."""
    cells = shapes.shape[1]
    repeats = -(-FEWEST_CELLS // cells)
    length = cells * repeats * train.period
    start = float(mean_points(shapes[0, 0])[2]) - 0.5 * train.period
    latitudes = int(np.clip(1300 / length, 32, 64))
    mesh = surface(degree_of(shapes), latitudes, 4 * latitudes // 3)
    return Scene(train, cells, repeats, tube_view(train, start, length), mesh)


@in_style()
def draw_snapshots(
    train: Train,
    times: Float[np.ndarray, " time"],
    shapes: Float[np.ndarray, "frame cell 3 coefficient"],
    *,
    velocities: Float[np.ndarray, "frame cell 3"] | None = None,
    dots_per_inch: int = 150,
) -> Figure:
    """The cells in their tube at the given times, row by row (Fig. 12).

    **Arguments:** `times` in r0/U, `shapes` in r0; `velocities` of the cells in U, drawn as arrows,
    such as the `centroid_velocity` of `celltrain.diagnostics.frame` less the steady train's;
    `dots_per_inch` of a picture that is 10 inches wide.

    **Raises:** `CaseError` if there is no time, or not one for each frame.
    """
    check_frames(times, shapes)
    scene = make_scene(train, shapes)
    # Short, wide tubes go side by side.
    columns = 1 if scene.ratio < WIDE or len(times) == 1 else 2
    width, rows = 10.0, -(-len(times) // columns)
    label = 0.28
    row = min(width / columns * scene.ratio, 4.0) + label
    height = rows * row + 0.35
    figure = Figure(figsize=(width, height), dpi=dots_per_inch)
    unit = 1.0
    if velocities is not None:
        unit = max(float(np.linalg.norm(velocities, axis=-1).max()), 1e-300)
    for number, time in enumerate(times):
        bottom = height - (number // columns + 1) * row
        left = number % columns / columns
        axes = figure.add_axes((left, bottom / height, 1.0 / columns, (row - label) / height))
        scene.draw(axes, shapes[number], None if velocities is None else velocities[number], unit)
        figure.text(
            left + 0.02,
            (bottom + row - 0.5 * label) / height,
            f"$t$ = {time:.4g} $r_0/U$",
            fontsize=10,
            color=INK,
            va="center",
        )
    caption = case_title(train)
    if velocities is not None:
        caption += f"; longest arrow {unit:.2g} $U$"
    figure.text(0.5, 0.1 / height, caption, ha="center", va="bottom", fontsize=9.5, color=INK)
    return figure


def check_frames(
    times: Float[np.ndarray, " time"], shapes: Float[np.ndarray, "frame cell 3 coefficient"]
) -> None:
    """Check that there is a time for each frame.

    **Raises:** `CaseError` otherwise.
    """
    if len(times) == 0 or len(times) != len(shapes):
        raise CaseError(
            f"{len(times)} times of {len(shapes)} frames are not allowed: allowed is one time for"
            " each frame, and at least one"
        )
