"""What all pictures share: a style, colours that colour-blind readers tell apart, words."""

from collections.abc import Iterator
from contextlib import contextmanager

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable

from celltrain.parameters import Train

# The palette of Okabe & Ito.
BLUE, VERMILION, GREEN, PURPLE = "#0072B2", "#D55E00", "#009E73", "#CC79A7"
ORANGE, SKY = "#E69F00", "#56B4E9"
#: The first for m = 0, or what there is several of.
COLORS = (BLUE, VERMILION, GREEN, PURPLE)
#: Letters and lines that are no data; data in the background.
INK, GREY = "0.15", "0.6"


@contextmanager
def in_style() -> Iterator[None]:
    """Draw within this, or a function that it decorates, in one style, whatever the user's is."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(
            {
                "figure.dpi": 200,
                "axes.titlelocation": "left",
                "axes.titlesize": 10,
                "legend.fontsize": 9,
                "legend.frameon": False,
                "xtick.direction": "in",
                "xtick.top": True,
                "ytick.direction": "in",
                "ytick.right": True,
            }
        )
        yield


def color_bar(axes: Axes, drawn: ScalarMappable, label: str) -> None:
    """A bar beside the axes that says which colour is which number."""
    bar = axes.figure.colorbar(drawn, ax=axes, label=label)
    bar.ax.tick_params(direction="out")


def case_title(train: Train) -> str:
    """What a picture says of its case."""
    return (
        f"$D$ = {train.tube.diameter:g} $r_0$, $\\phi$ = {train.packing:g}, $N$ = {train.cells}, "
        f"viscosity ratio {train.flow.viscosity_ratio:g}"
    )
