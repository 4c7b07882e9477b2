"""What a simulation records of its cells, over time: places, turning, gaps, energies."""

from pathlib import Path

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from celltrain.evolution import Run
from celltrain.parameters import CaseError
from celltrain.pictures.style import BLUE, GREEN, GREY, PURPLE, VERMILION, case_title


def draw_record(run: Run, path: Path) -> Path:
    """Six quantities of all frames, each cell a line, cells A and B in colour; returns `path`.

    **Raises:** `CaseError` if there are fewer than two frames; `OSError` if the picture cannot be
    written.
    """
    if len(run.times) < 2:
        raise CaseError("one frame cannot be drawn over time: allowed are two or more")
    frames, times = run.frames, run.times
    centroids = frames["centroid"]
    figure = Figure(figsize=(9.0, 8.0), dpi=150, layout="constrained")
    panels = figure.subplots(3, 2, sharex=True)
    _cells(panels[0, 0], times, np.hypot(centroids[..., 0], centroids[..., 1]))
    _title(panels[0, 0], "distance of the centroid from the axis ($r_0$)")
    _cells(panels[0, 1], times, centroids[..., 2] - centroids[0, :, 2])
    _title(panels[0, 1], "axial displacement from the steady train ($r_0$)")
    _cells(panels[1, 0], times, np.rad2deg(frames["inclination"]))
    _title(panels[1, 0], "inclination to the axis (degrees)")
    _lines(
        panels[1, 1],
        times,
        {
            "from another cell": (frames["cell_distance"].min(axis=1), BLUE),
            "from the wall": (frames["wall_distance"].min(axis=1), VERMILION),
        },
    )
    _title(panels[1, 1], "smallest distances ($r_0$)")
    _lines(
        panels[2, 0],
        times,
        {
            r"tumbling, $|\omega|$": (frames["tumbling"].mean(axis=1), BLUE),
            r"tank-treading, $|\Omega - \omega|$": (
                frames["tank_treading"].mean(axis=1),
                VERMILION,
            ),
        },
    )
    _title(panels[2, 0], "turning, mean over the cells ($U/r_0$)")
    _lines(
        panels[2, 1],
        times,
        {
            "shear": (frames["energy_shear"].sum(axis=1), BLUE),
            "dilatation": (frames["energy_dilatation"].sum(axis=1), GREEN),
            "bending": (frames["energy_bending"].sum(axis=1), PURPLE),
        },
    )
    _title(panels[2, 1], r"elastic energy of all cells ($\mu U r_0^2$)")
    for axes in panels.flat:
        axes.set_xlim(times[0], times[-1])
        axes.tick_params(direction="in", top=True, right=True)
    for axes in panels[-1]:
        axes.set_xlabel("$t$ ($r_0/U$)")
    figure.suptitle(case_title(run.train), fontsize=10)
    figure.savefig(path)
    return path


def _title(axes: Axes, text: str) -> None:
    axes.set_title(text, loc="left", fontsize=9)


def _cells(
    axes: Axes, times: Float[np.ndarray, " time"], values: Float[np.ndarray, "time cell"]
) -> None:
    """A line for each cell; the first two, which snapshots name, in colour."""
    axes.plot(times, values[:, 2:], color=GREY, linewidth=0.8)
    if values.shape[1] == 1:
        axes.plot(times, values[:, 0], color=BLUE, linewidth=1.5)
        return
    for cell, (name, color) in enumerate((("A", BLUE), ("B", VERMILION))):
        axes.plot(times, values[:, cell], color=color, linewidth=1.5, label=name)
    axes.legend(frameon=False, fontsize=8)


def _lines(
    axes: Axes,
    times: Float[np.ndarray, " time"],
    curves: dict[str, tuple[Float[np.ndarray, " time"], str]],
) -> None:
    for label, (values, color) in curves.items():
        axes.plot(times, values, color=color, linewidth=1.5, label=label)
    axes.set_ylim(bottom=0.0)
    axes.legend(frameon=False, fontsize=8)
