"""A simulation as a film: the cells in their tube, frame by frame."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from jaxtyping import Float
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, PillowWriter
from matplotlib.figure import Figure

from celltrain.parameters import CaseError, Train
from celltrain.pictures.evolution import check_frames, make_scene
from celltrain.pictures.style import INK, case_title, in_style

WIDTH = 8.0
DOTS = 110

#: Called with the number of frames drawn and that of all.
FilmProgress = Callable[[int, int], None]


@in_style()
def animate(
    train: Train,
    times: Float[np.ndarray, " time"],
    shapes: Float[np.ndarray, "frame cell 3 coefficient"],
    path: Path,
    *,
    frames_per_second: int = 12,
    progress: FilmProgress | None = None,
) -> Path:
    """Write frames of a simulation as a film; returns `path`.

    **Arguments:** `times` in r0/U, `shapes` in r0; `path` ends in `.gif`, or in `.mp4` where the
    program `ffmpeg` is installed. Every frame is shown equally long and takes about half a second
    to draw.

    **Raises:** `CaseError` for another ending, `.mp4` without ffmpeg, no frame, or not a time for
    each; `OSError` if the film cannot be written.
    """
    check_frames(times, shapes)
    writer = film_writer(path, frames_per_second)
    scene = make_scene(train, shapes)
    picture = min(WIDTH * scene.ratio, 5.0)
    text = 0.34
    height = picture + text
    figure = Figure(figsize=(WIDTH, height))
    with writer.saving(figure, str(path), DOTS):
        for number, (time, shape) in enumerate(zip(times, shapes, strict=True), 1):
            figure.clear()
            scene.draw(figure.add_axes((0.0, text / height, 1.0, picture / height)), shape)
            words = f"$t$ = {time:.1f} $r_0/U$,  {case_title(train)}"
            place = (0.5, 0.5 * text / height)
            figure.text(*place, words, ha="center", va="center", fontsize=9.5, color=INK)
            writer.grab_frame()
            if progress is not None:
                progress(number, len(times))
    return path


def film_writer(path: Path, frames_per_second: int = 12) -> AbstractMovieWriter:
    """What writes a film of this name.

    **Raises:** `CaseError` for an ending other than `.gif` and `.mp4`, or `.mp4` without ffmpeg.
    """
    if path.suffix == ".gif":
        return PillowWriter(fps=frames_per_second)
    if path.suffix == ".mp4":
        if not FFMpegWriter.isAvailable():
            raise CaseError(f"{path.name} needs the program ffmpeg; without it allowed: .gif")
        return FFMpegWriter(fps=frames_per_second)
    raise CaseError(f"{path.name} is not allowed as a film: allowed are .gif and .mp4")
