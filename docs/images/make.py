"""Pictures of the README: a train, and its breakup.

python docs/images/make.py. `train.png` is computed, in some seconds. `breakup.png` is put together
of two frames of the simulation of twelve cells in `docs/validation/breakup-twelve.png`, which takes
hours (`python validation/run.py breakup --simulate twelve`).
"""

from pathlib import Path

import matplotlib.image as mpimg
import numpy as np
from matplotlib.figure import Figure

from celltrain import Train, steady
from celltrain.pictures import draw_base_train

HERE = Path(__file__).parent
FRAMES = HERE.parent / "validation" / "breakup-twelve.png"
WHITE = 0.97


def window(picture: np.ndarray) -> tuple[slice, slice]:
    """Rows and columns of a picture between its white edges."""
    ink = (picture[..., :3] < WHITE).any(axis=-1)
    rows, columns = np.flatnonzero(ink.any(axis=1)), np.flatnonzero(ink.any(axis=0))
    return slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)


def draw_breakup() -> Figure:
    """The first frame and the last beside each other, without their captions."""
    picture = mpimg.imread(FRAMES)
    height, width = picture.shape[:2]
    # Two rows of two frames; a caption below, and a title above each frame.
    middle, row, title = width // 2, round(0.475 * height), round(0.045 * height)
    first, last = picture[title:row, :middle], picture[row + title : 2 * row, middle:]
    # The tube stands in the same place in both.
    shown = window(first)
    figure = Figure(figsize=(11.0, 3.1), dpi=150, facecolor="white")
    for left, frame, words in (
        (0.0, first, "$t$ = 0: twelve cells in file, a little displaced"),
        (0.505, last, "$t$ = 600 $r_0/U$: out of order"),
    ):
        axes = figure.add_axes((left + 0.005, 0.01, 0.485, 0.88))
        axes.imshow(frame[shown], interpolation="lanczos")
        axes.set_axis_off()
        axes.set_title(words, fontsize=11, loc="left", pad=4)
    return figure


def main() -> None:
    """Draw both."""
    base = steady(Train(diameter=4, packing=0.3, cells=6, degree=16))
    for name, figure in (("train", draw_base_train(base)), ("breakup", draw_breakup())):
        figure.savefig(HERE / f"{name}.png")
        print(HERE / f"{name}.png")


if __name__ == "__main__":
    main()
