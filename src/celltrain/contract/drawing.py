"""Pictures that look the same everywhere, and are whole when they are there."""

from pathlib import Path

from celltrain.contract.analysis import Draw
from celltrain.results import replace_file


def draw_file(draw: Draw, path: Path) -> Path:
    """Draw a picture into a file, which is replaced when the picture is complete; returns `path`.

    The user's settings of Matplotlib (style files, LaTeX, fonts, formats) do not count, and are as
    they were afterwards.

    Raises:
        OSError: if the file cannot be written; an older one is left as it was.
    """
    import matplotlib as mpl  # takes a good part of a second

    with mpl.rc_context():
        mpl.rcdefaults()
        replace_file(path, draw().savefig)
    return path
