"""Trains of shaded cells in their tube: at rest, and with a disturbance added (Figs. 5, 6b, 8b)."""

from dataclasses import replace

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
from celltrain.pictures.style import INK, case_title, in_style
from celltrain.pictures.surface import surface
from celltrain.pictures.tube import TubeView, tube_view
from celltrain.stability import Stability
from celltrain.steady import Base

# A window of a long train, and as many periods of a short one as make a train of it.
MOST_CELLS = 12
FEWEST_CELLS = 3


@in_style()
def draw_base_train(base: Base) -> Figure:
    """The steady train, every cell in its place."""
    train = base.train
    shapes = np.broadcast_to(base.coefficients, (train.cells, *base.coefficients.shape))
    return _figure(
        train,
        np.asarray(shapes),
        f"Steady train, {case_title(train)}: the cells move at {base.cell_velocity:.4g} $U$.",
    )


@in_style()
def draw_leading_mode(result: Stability) -> Figure:
    """The train plus its fastest growing disturbance, neutral ones set aside (Fig. 6b)."""
    mode = result.leading
    fate = "Fastest growing" if mode.growth_rate > 0 else "Slowest decaying"
    return _draw_disturbed(
        result,
        result.shape(mode),
        f"{fate} disturbance",
        f"{_pattern(mode.azimuthal_number, mode.wave_number, result)}, "
        f"growth rate {mode.growth_rate:.3g} $U/r_0$",
    )


@in_style()
def draw_transient_mode(result: Stability) -> Figure:
    """The train plus the disturbance that grows most at first (Fig. 8b)."""
    transient = result.transient
    return _draw_disturbed(
        result,
        result.transient_shape(),
        "Disturbance that grows fastest at first",
        f"{_pattern(transient.azimuthal_number, transient.wave_number, result)}, "
        f"initial growth rate {transient.growth_rate:.3g} $U/r_0$",
    )


def _draw_disturbed(
    result: Stability,
    disturbance: Float[np.ndarray, "cell 3 coefficient"],
    name: str,
    facts: str,
) -> Figure:
    train = result.base.train
    drawn: Drawn = draw_amplitude(
        result.base.coefficients,
        disturbance,
        period=train.period,
        radius=train.radius,
        camera=_tube(train).camera,
    )
    return _figure(
        train,
        drawn.coefficients,
        f"{name}, {case_title(train)}: {facts}.\n"
        f"Exaggerated: drawn with a largest displacement of {drawn.displacement:.2g} $r_0$; "
        "dashed, the undisturbed cells.",
        ghost=result.base.coefficients,
    )


def _window(train: Train) -> Int[np.ndarray, "place"]:
    """Which cell stands at each place drawn: all, a window, or several periods of a short train."""
    places = min(train.cells, MOST_CELLS)
    if places < FEWEST_CELLS:
        places = train.cells * -(-FEWEST_CELLS // train.cells)
    return np.arange(places) % train.cells


def _tube(train: Train) -> TubeView:
    """The tube around the places drawn."""
    return tube_view(train, -0.5 * train.period, len(_window(train)) * train.period)


def _figure(
    train: Train,
    shapes: Float[np.ndarray, "cell 3 coefficient"],
    caption: str,
    *,
    ghost: Float[np.ndarray, "3 coefficient"] | None = None,
) -> Figure:
    """The picture itself: tube, cells, arrow of the flow, caption."""
    window, tube = _window(train), _tube(train)
    # Faces of about three dots, whether a few cells fill the picture or many share it.
    latitudes = int(np.clip(1300 / (len(window) * train.period), 48, 72))
    mesh = surface(degree_of(shapes), latitudes, 4 * latitudes // 3)
    shift = np.zeros((len(window), 1, 3))
    shift[:, 0, 2] = train.period * np.arange(len(window))
    local = mesh.vertices(shapes[window])
    vertices = local + shift
    # Cells of a dense train reach beyond their own period: let the tube cover them.
    start = min(tube.start, float(vertices[..., 2].min()) - 0.35)
    end = max(tube.end, float(vertices[..., 2].max()) + 0.35)
    tube = replace(tube, start=start, end=end)

    # At least as wide as the caption needs, and not taller than a page.
    lowest = min(height for _, height in _flow_arrow(tube)) - 0.2
    width, tall = np.ptp(tube.limits(lowest), axis=0)
    inches = 10.0
    picture = min(inches * tall / width, 5.6)
    caption += _shown(train, window)
    text = 0.16 + 0.2 * (caption.count("\n") + 1)
    height = picture + text
    figure = Figure(figsize=(inches, height))
    axes = figure.add_axes((0.0, text / height, 1.0, picture / height))
    tube.draw(axes, lowest)
    draw_surfaces(axes, tube.camera, vertices, mesh.normals(local), mesh.faces)
    if ghost is not None:
        _outlines(axes, tube.camera, mesh.vertices(ghost) + shift)
    _draw_arrow(axes, *_flow_arrow(tube))
    figure.text(0.5, 0.1 / height, caption, ha="center", va="bottom", fontsize=9.5, color=INK)
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


def _flow_arrow(tube: TubeView) -> tuple[tuple[float, float], tuple[float, float]]:
    """Tail and head of an arrow along the tube, below its inlet half."""
    length = min(0.22 * (tube.end - tube.start), 5.0)
    line = [[0.0, -1.12 * tube.radius, height] for height in (tube.start, tube.start + length)]
    (tail, head), _ = tube.camera.project(np.array(line))
    return (tail[0], tail[1]), (head[0], head[1])


def _draw_arrow(axes: Axes, tail: tuple[float, float], head: tuple[float, float]) -> None:
    axes.add_patch(
        FancyArrowPatch(
            tail, head, arrowstyle="-|>", mutation_scale=14, linewidth=1.4, color=INK, zorder=4
        )
    )
    place = "offset points"
    axes.annotate("flow", head, (5, 0), textcoords=place, va="center", fontsize=10, color=INK)


def _pattern(azimuthal_number: int, wave_number: int, result: Stability) -> str:
    cells = result.base.train.cells
    if wave_number == 0:
        wave = "all cells alike"
    elif 2 * wave_number == cells:
        wave = "two cells a wave"
    else:
        wave = f"{cells / wave_number:.3g} cells a wave"
    return f"$m$ = {azimuthal_number}, $j$ = {wave_number} ({wave})"


def _shown(train: Train, window: Int[np.ndarray, "place"]) -> str:
    if len(window) < train.cells:
        return f" The first {len(window)} of {train.cells} cells are shown."
    if len(window) > train.cells:
        return f" {len(window) // train.cells} periods of the train are shown."
    return ""
