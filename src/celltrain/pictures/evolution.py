"""Pictures of a simulation: how a disturbance grows (Fig. 4), and the cells at chosen times.

The input is plain arrays, wherever they come from.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from celltrain.harmonics import Shapes, degree_of, displaced_along, mean_points
from celltrain.parameters import CaseError, Train
from celltrain.pictures.camera import Camera
from celltrain.pictures.render import draw_surfaces
from celltrain.pictures.style import BLUE, INK, VERMILION, case_title
from celltrain.pictures.surface import Mesh, surface
from celltrain.pictures.train import FEWEST_CELLS
from celltrain.pictures.tube import draw_tube

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


def plot_growth(
    train: Train, growth: Growth, path: Path, *, logarithmic_time: bool = False
) -> Path:
    """The size of a disturbance over time, beside its linear predictions; returns `path`.

    Logarithmic in size, as Figs. 4 and 11; exp(alpha t) begins at the first size.

    **Arguments:** `logarithmic_time`: logarithmic in time, too, as Fig. 4, which shows what happens
    at first.

    **Raises:** `CaseError` if fewer than two times or arrays of other lengths are given; `OSError`
    if the picture cannot be written.
    """
    times = growth.times
    curves = [growth.size, growth.displacement, growth.linear]
    if len(times) < 2 or any(each is not None and len(each) != len(times) for each in curves):
        raise CaseError(
            f"{len(times)} times with curves of {[len(c) for c in curves if c is not None]} values"
            " are not allowed: allowed are two times or more and as many values"
        )
    figure = Figure(figsize=(7.2, 4.6), dpi=200, layout="constrained")
    axes = figure.add_subplot()
    axes.plot(times, growth.size, color=BLUE, linewidth=1.8, label=r"simulation, $\epsilon$")
    if growth.displacement is not None:
        axes.plot(
            times,
            growth.displacement,
            color=VERMILION,
            linewidth=1.8,
            label=r"simulation, $\epsilon_x$",
        )
    if growth.linear is not None:
        axes.plot(
            times,
            growth.linear,
            color=INK,
            linewidth=1.1,
            linestyle=(0, (5, 2)),
            label=r"linear, $|e^{At} v|$",
        )
    if growth.growth_rate is not None:
        axes.plot(
            times,
            growth.size[0] * np.exp(growth.growth_rate * (times - times[0])),
            color=INK,
            linewidth=1.1,
            linestyle=(0, (1, 1.6)),
            label=rf"$e^{{\alpha t}}$, $\alpha$ = {growth.growth_rate:.3g} $U/r_0$",
        )
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
    axes.set_title(case_title(train), loc="left", fontsize=10)
    axes.tick_params(direction="in", which="both", top=True, right=True)
    axes.legend(frameon=False, fontsize=9)
    figure.savefig(path)
    return path


@dataclass(frozen=True)
class Scene:
    """The tube, seen from the side, into which cells of any frame are put.

    The window is as long as the train, or as several of its periods if it is short; a cell that
    left it downstream is drawn where its image enters upstream.

    Attributes:
        train: the case.
        cells: number of cells in a period.
        repeats: periods shown.
        start: axial position (r0) at which the window begins.
        mesh: the mesh of a cell.
        camera: the eye.
    """

    train: Train
    cells: int
    repeats: int
    start: float
    mesh: Mesh
    camera: Camera

    @property
    def length(self) -> float:
        """Period of the train, r0."""
        return self.cells * self.train.period

    @property
    def end(self) -> float:
        """Axial position (r0) at which the window ends."""
        return self.start + self.repeats * self.length

    @property
    def ratio(self) -> float:
        """Height over width of the picture."""
        low, high = self._extent()
        return float((high[1] - low[1]) / (high[0] - low[0]))

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
        axes.set_axis_off()
        axes.set_aspect("equal")
        low, high = self._extent()
        axes.set_xlim(low[0], high[0])
        axes.set_ylim(low[1], high[1])
        draw_tube(axes, self.camera, self.train.radius, self.start, self.end)
        placed = self.placed(shapes)
        vertices = self.mesh.vertices(placed)
        normals = self.mesh.normals(vertices)
        draw_surfaces(axes, self.camera, vertices, normals, self.mesh.faces)
        middles = vertices.mean(axis=1)
        if self.cells >= 2:
            for name, cell in zip("AB", vertices[:2], strict=True):
                self._write(axes, name, cell)
        if velocities is not None:
            ends = middles + ARROW / unit * np.tile(velocities, (self.repeats, 1))
            for tail, head in zip(middles, ends, strict=True):
                (first, last), _ = self.camera.project(np.stack([tail, head]))
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
        flat = self.camera.project(cell)[0]
        x, y = 0.5 * (flat[:, 0].min() + flat[:, 0].max()), flat[:, 1].max()
        axes.text(x, y + 0.15, name, color=INK, fontsize=9, ha="center", va="bottom", zorder=4)

    def placed(self, shapes: Shapes) -> Float[np.ndarray, "place 3 coefficient"]:
        """The shapes as they are shown: in the window, and again for every period in it."""
        height = mean_points(shapes)[:, 2]
        back = self.length * np.floor((height - self.start) / self.length)
        repeats = self.length * np.arange(self.repeats)
        moves = (repeats[:, None] - back).ravel()
        return displaced_along(np.tile(shapes, (self.repeats, 1, 1)), moves)

    def _extent(self) -> tuple[Float[np.ndarray, "2"], Float[np.ndarray, "2"]]:
        angle = np.linspace(0.0, 2 * np.pi, 60)
        radius = self.train.radius
        rings = np.stack(
            [
                np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle + z], axis=-1)
                for z in (self.start, self.end)
            ]
        )
        flat = self.camera.project(rings)[0].reshape(-1, 2)
        margin = 0.02 * np.ptp(flat[:, 0])
        return flat.min(axis=0) - margin, flat.max(axis=0) + margin


def make_scene(train: Train, shapes: Float[np.ndarray, "time cell 3 coefficient"]) -> Scene:
    """A stage for all of the given frames, whose window begins half a period before a cell."""
    cells = shapes.shape[1]
    repeats = -(-FEWEST_CELLS // cells)
    length = cells * repeats * train.period
    start = float(mean_points(shapes[0, 0])[2]) - 0.5 * train.period
    latitudes = int(np.clip(1300 / length, 32, 64))
    return Scene(
        train=train,
        cells=cells,
        repeats=repeats,
        start=start,
        mesh=surface(degree_of(shapes), latitudes, 4 * latitudes // 3),
        # Flatter for long trains, as in the pictures of steady ones.
        camera=Camera(
            np.array([0.0, 0.0, start + 0.5 * length]), 2.6 * length + 3.0 * train.tube.diameter
        ),
    )


def draw_snapshots(
    train: Train,
    times: Float[np.ndarray, " time"],
    shapes: Float[np.ndarray, "frame cell 3 coefficient"],
    path: Path,
    *,
    velocities: Float[np.ndarray, "frame cell 3"] | None = None,
    dots_per_inch: int = 150,
) -> Path:
    """The cells in their tube at the given times, row by row (Fig. 12); returns `path`.

    **Arguments:** `times` in r0/U, `shapes` in r0; `velocities` of the cells in U, drawn as arrows,
    such as the `centroid_velocity` of `celltrain.diagnostics.frame` less the steady train's;
    `dots_per_inch` of a picture that is 10 inches wide.

    **Raises:** `CaseError` if there is no time, or not one for each frame; `OSError` if the picture
    cannot be written.
    """
    check_frames(times, shapes)
    stage = make_scene(train, shapes)
    # Short, wide tubes go side by side.
    columns = 1 if stage.ratio < WIDE or len(times) == 1 else 2
    width, rows = 10.0, -(-len(times) // columns)
    label = 0.28
    row = min(width / columns * stage.ratio, 4.0) + label
    height = rows * row + 0.35
    figure = Figure(figsize=(width, height), dpi=dots_per_inch, facecolor="white")
    unit = 1.0
    if velocities is not None:
        unit = max(float(np.linalg.norm(velocities, axis=-1).max()), 1e-300)
    for number, time in enumerate(times):
        bottom = height - (number // columns + 1) * row
        left = number % columns / columns
        axes = figure.add_axes((left, bottom / height, 1.0 / columns, (row - label) / height))
        stage.draw(axes, shapes[number], None if velocities is None else velocities[number], unit)
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
    figure.savefig(path)
    return path


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
