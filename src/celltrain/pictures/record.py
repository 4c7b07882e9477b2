"""What a simulation records of its cells, over time: places, turning, gaps, energies."""

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from celltrain.evolution import Run
from celltrain.parameters import CaseError
from celltrain.pictures.style import BLUE, GREEN, GREY, PURPLE, VERMILION, case_title, in_style


@in_style()
def draw_record(run: Run) -> Figure:
    """Six quantities of all frames, each cell a line, cells A and B in colour.

    **Raises:** `CaseError` if there are fewer than two frames.
    """
    if len(run.times) < 2:
        raise CaseError("one frame cannot be drawn over time: allowed are two or more")
    frames, times = run.frames, run.times
    centroids = frames["centroid"]
    of_cells = {
        "distance of the centroid from the axis ($r_0$)": np.linalg.norm(
            centroids[..., :2], axis=-1
        ),
        "axial displacement from the steady train ($r_0$)": (centroids - centroids[0])[..., 2],
        "inclination to the axis (degrees)": np.rad2deg(frames["inclination"]),
    }
    of_all = {
        "smallest distances ($r_0$)": {
            "from another cell": (frames["cell_distance"].min(axis=1), BLUE),
            "from the wall": (frames["wall_distance"].min(axis=1), VERMILION),
        },
        "turning, mean over the cells ($U/r_0$)": {
            r"tumbling, $|\omega|$": (frames["tumbling"].mean(axis=1), BLUE),
            r"tank-treading, $|\Omega - \omega|$": (
                frames["tank_treading"].mean(axis=1),
                VERMILION,
            ),
        },
        r"elastic energy of all cells ($\mu U r_0^2$)": {
            "shear": (frames["energy_shear"].sum(axis=1), BLUE),
            "dilatation": (frames["energy_dilatation"].sum(axis=1), GREEN),
            "bending": (frames["energy_bending"].sum(axis=1), PURPLE),
        },
    }
    figure = Figure(figsize=(9.0, 8.0), dpi=150, layout="constrained")
    panels = figure.subplots(3, 2, sharex=True)
    for axes, title in zip(panels.flat, (*of_cells, *of_all), strict=True):
        axes.set_title(title, fontsize=9)
        if title in of_cells:
            _cells(axes, times, of_cells[title])
            continue
        for label, (values, color) in of_all[title].items():
            axes.plot(times, values, color=color, linewidth=1.5, label=label)
        axes.set_ylim(bottom=0.0)
        axes.legend(fontsize=8)
    panels[0, 0].set_xlim(times[0], times[-1])
    for axes in panels[-1]:
        axes.set_xlabel("$t$ ($r_0/U$)")
    figure.suptitle(case_title(run.train), fontsize=10)
    return figure


def _cells(
    axes: Axes, times: Float[np.ndarray, " time"], values: Float[np.ndarray, "time cell"]
) -> None:
    """A line for each cell; the first two, which snapshots name, in colour."""
    axes.plot(times, values[:, 2:], color=GREY, linewidth=0.8)
    if values.shape[1] == 1:
        axes.plot(times, values[:, 0], color=BLUE, linewidth=1.5)
        return
    # Dashed, so that the first is seen where they are alike.
    for cell, (name, color, line) in enumerate((("A", BLUE, "-"), ("B", VERMILION, "--"))):
        axes.plot(times, values[:, cell], line, color=color, linewidth=1.5, label=name)
    axes.legend(fontsize=8)
