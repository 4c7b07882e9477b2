"""What a picture shows: its figure, and whether all of its words lie inside it."""

from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import BboxBase

#: Parts of a pixel by which a text's box may reach over the edge.
SLACK = 1.0


def saved(figure: Figure, path: Path) -> Path:
    """The file that a figure is saved to."""
    figure.savefig(path)
    return path


def words_outside(figure: Figure) -> list[str]:
    """Texts that do not lie inside the figure; labels of ticks as one text for each axis."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    axes = [axis for each in figure.axes if each.axison for axis in (each.xaxis, each.yaxis)]
    of_ticks = {
        label
        for each in figure.axes
        for axis in (each.xaxis, each.yaxis)
        for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks())
        for label in (tick.label1, tick.label2)
    }
    boxes = [("ticks", axis.get_tightbbox(renderer)) for axis in axes if axis.get_visible()]
    boxes += [
        (text.get_text(), text.get_window_extent(renderer))
        for text in figure.findobj(Text)
        if text not in of_ticks and text.get_visible() and text.get_text().strip()
    ]
    return [words for words, box in boxes if box is not None and not _inside(box, figure.bbox)]


def labels(figure: Figure) -> set[str]:
    """Words of all legends, and labels of all axes."""
    found = {text.get_text() for legend in figure.legends for text in legend.get_texts()}
    for axes in figure.axes:
        found |= {axes.get_xlabel(), axes.get_ylabel()}
        legend = axes.get_legend()
        if legend is not None:
            found |= {text.get_text() for text in legend.get_texts()}
    return found - {""}


def _inside(box: BboxBase, whole: BboxBase) -> bool:
    return bool(
        box.x0 >= whole.x0 - SLACK
        and box.y0 >= whole.y0 - SLACK
        and box.x1 <= whole.x1 + SLACK
        and box.y1 <= whole.y1 + SLACK
    )
