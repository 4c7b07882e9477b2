"""Trains of shaded cells in their tube: at rest, and with a disturbance added (Figs. 5, 6b, 8b)."""

from pathlib import Path

import numpy as np
from jaxtyping import Float, Int
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch
from scipy.spatial import ConvexHull

from celltrain.harmonics import degree_of
from celltrain.parameters import Train
from celltrain.pictures.camera import Camera
from celltrain.pictures.disturbance import Drawn, draw_amplitude
from celltrain.pictures.render import draw_surfaces
from celltrain.pictures.style import INK, case_title
from celltrain.pictures.surface import surface
from celltrain.pictures.tube import draw_tube
from celltrain.stability import Stability
from celltrain.steady import Base

# A window of a long train, and as many periods of a short one as make a train of it.
MOST_CELLS = 12
FEWEST_CELLS = 3


def draw_base_train(base: Base, path: Path) -> Path:
    """Picture of the steady train, every cell in its place; returns `path`.

    Raises:
        OSError: if the picture cannot be written.
    """
    train = base.train
    shapes = np.broadcast_to(base.coefficients, (train.cells, *base.coefficients.shape))
    figure = _figure(
        train,
        np.asarray(shapes),
        f"Steady train, {case_title(train)}: the cells move at {base.cell_velocity:.4g} $U$.",
    )
    figure.savefig(path)
    return path


def draw_leading_mode(result: Stability, path: Path) -> Path:
    """Picture of the train plus its fastest growing disturbance, neutral ones set aside (Fig. 6b).

    Raises:
        OSError: if the picture cannot be written.
    """
    mode = result.leading
    fate = "Fastest growing" if mode.growth_rate > 0 else "Slowest decaying"
    return _draw_disturbed(
        result,
        result.shape(mode),
        f"{fate} disturbance",
        f"{_pattern(mode.azimuthal_number, mode.wave_number, result)}, "
        f"growth rate {mode.growth_rate:.3g} $U/r_0$",
        path,
    )


def draw_transient_mode(result: Stability, path: Path) -> Path:
    """Picture of the train plus the disturbance that grows most at first (Fig. 8b).

    Raises:
        OSError: if the picture cannot be written.
    """
    transient = result.transient
    return _draw_disturbed(
        result,
        result.transient_shape(),
        "Disturbance that grows fastest at first",
        f"{_pattern(transient.azimuthal_number, transient.wave_number, result)}, "
        f"initial growth rate {transient.growth_rate:.3g} $U/r_0$",
        path,
    )


def _draw_disturbed(
    result: Stability,
    disturbance: Float[np.ndarray, "cell 3 coefficient"],
    name: str,
    facts: str,
    path: Path,
) -> Path:
    train = result.base.train
    drawn: Drawn = draw_amplitude(
        result.base.coefficients,
        disturbance,
        period=train.period,
        radius=train.radius,
        camera=_camera(train, _window(train)),
    )
    figure = _figure(
        train,
        drawn.coefficients,
        f"{name}, {case_title(train)}: {facts}.\n"
        f"Exaggerated: drawn with a largest displacement of {drawn.displacement:.2g} $r_0$; "
        "dashed, the undisturbed cells.",
        ghost=result.base.coefficients,
    )
    figure.savefig(path)
    return path


def _window(train: Train) -> Int[np.ndarray, "place"]:
    """Which cell stands at each place drawn: all, a window, or several periods of a short train."""
    places = min(train.cells, MOST_CELLS)
    if places < FEWEST_CELLS:
        places = train.cells * -(-FEWEST_CELLS // train.cells)
    return np.arange(places) % train.cells


def _camera(train: Train, window: Int[np.ndarray, "place"]) -> Camera:
    length = len(window) * train.period
    middle = 0.5 * (len(window) - 1) * train.period
    # Flatter for long trains, which slight perspective would otherwise shrink too much downstream.
    distance = 2.6 * length + 3.0 * train.tube.diameter
    return Camera(np.array([0.0, 0.0, middle]), distance)


def _figure(
    train: Train,
    shapes: Float[np.ndarray, "cell 3 coefficient"],
    caption: str,
    *,
    ghost: Float[np.ndarray, "3 coefficient"] | None = None,
) -> Figure:
    """The picture itself: tube, cells, arrow of the flow, caption."""
    window = _window(train)
    camera = _camera(train, window)
    # Faces of about three dots, whether a few cells fill the picture or many share it.
    latitudes = int(np.clip(1300 / (len(window) * train.period), 48, 72))
    mesh = surface(degree_of(shapes), latitudes, 4 * latitudes // 3)
    shift = np.zeros((len(window), 1, 3))
    shift[:, 0, 2] = train.period * np.arange(len(window))
    local = mesh.vertices(shapes[window])
    vertices = local + shift
    start = -0.5 * train.period
    end = start + len(window) * train.period
    # Cells of a dense train reach beyond their own period: let the tube cover them.
    start = min(start, float(vertices[..., 2].min()) - 0.35)
    end = max(end, float(vertices[..., 2].max()) + 0.35)

    figure = Figure(figsize=(10.0, 4.0), dpi=200, facecolor="white")
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    axes.set_aspect("equal")
    draw_tube(axes, camera, train.radius, start, end)
    draw_surfaces(axes, camera, vertices, mesh.normals(local), mesh.faces)
    if ghost is not None:
        _outlines(axes, camera, mesh.vertices(ghost) + shift)
    lowest = _flow_arrow(axes, camera, train.radius, start, end)
    _frame(figure, axes, camera, train.radius, start, end, lowest, caption + _extent(train, window))
    return figure


def _outlines(axes: Axes, camera: Camera, vertices: Float[np.ndarray, "cell vertex 3"]) -> None:
    """Outlines of the undisturbed cells, over the disturbed ones."""
    for flat in camera.project(vertices)[0]:
        hull = ConvexHull(flat).vertices
        hull = np.append(hull, hull[0])
        axes.plot(
            flat[hull, 0],
            flat[hull, 1],
            color="0.1",
            linewidth=0.8,
            linestyle=(0, (4, 2.5)),
            zorder=2.6,
        )


def _flow_arrow(axes: Axes, camera: Camera, radius: float, start: float, end: float) -> float:
    """Arrow along the tube, below its inlet half; returns the lowest height it takes."""
    length = min(0.22 * (end - start), 5.0)
    line = np.array([[0.0, -1.12 * radius, start], [0.0, -1.12 * radius, start + length]])
    (tail, head), _ = camera.project(line)
    axes.add_patch(
        FancyArrowPatch(
            tail, head, arrowstyle="-|>", mutation_scale=14, linewidth=1.4, color=INK, zorder=4
        )
    )
    axes.annotate(
        "flow",
        head,
        xytext=(5, 0),
        textcoords="offset points",
        va="center",
        ha="left",
        fontsize=10,
        color=INK,
    )
    return float(min(tail[1], head[1]))


def _frame(
    figure: Figure,
    axes: Axes,
    camera: Camera,
    radius: float,
    start: float,
    end: float,
    lowest: float,
    caption: str,
) -> None:
    """Fit the axes to the tube and the figure to the axes, with the caption below."""
    angle = np.linspace(0.0, 2 * np.pi, 60)
    rings = np.stack(
        [
            np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle + z], axis=-1)
            for z in (start, end)
        ]
    )
    flat = camera.project(rings)[0].reshape(-1, 2)
    low, high = flat.min(axis=0), flat.max(axis=0)
    low[1] = min(low[1], lowest - 0.2)
    margin = 0.02 * (high[0] - low[0])
    low, high = low - margin, high + margin
    width, tall = high - low

    # At least as wide as the caption needs, and not taller than a page.
    inches = 10.0
    picture = min(inches * tall / width, 5.6)
    text = 0.16 + 0.2 * (caption.count("\n") + 1)
    figure.set_size_inches(inches, picture + text)
    axes.set_position((0.0, text / (picture + text), 1.0, picture / (picture + text)))
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    figure.text(
        0.5, 0.1 / (picture + text), caption, ha="center", va="bottom", fontsize=9.5, color=INK
    )


def _pattern(azimuthal_number: int, wave_number: int, result: Stability) -> str:
    cells = result.base.train.cells
    if wave_number == 0:
        wave = "all cells alike"
    elif 2 * wave_number == cells:
        wave = "two cells a wave"
    else:
        wave = f"{cells / wave_number:.3g} cells a wave"
    return f"$m$ = {azimuthal_number}, $j$ = {wave_number} ({wave})"


def _extent(train: Train, window: Int[np.ndarray, "place"]) -> str:
    if len(window) < train.cells:
        return f" The first {len(window)} of {train.cells} cells are shown."
    if len(window) > train.cells:
        return f" {len(window) // train.cells} periods of the train are shown."
    return ""
