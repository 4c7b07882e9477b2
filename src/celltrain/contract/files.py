"""Whatever was computed: read from its file, printed again, drawn."""

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path

from rich.console import Console

from celltrain.contract.analysis import Draw
from celltrain.contract.catalogue import kinds, presentation
from celltrain.contract.drawing import draw_file
from celltrain.quantities import Record


def load(path: str | Path) -> Record:
    """Read any result that was saved: it equals what was computed.

    Raises:
        OSError: if the file cannot be read, or is of another version that this one cannot read.
        ForeignFile: a `ValueError`, if it is not a file of this package.
    """
    # Commands that read no file do not wait for this.
    from celltrain.results.netcdf import ForeignFile, read_as, read_content

    content = read_content(path)
    kind = str(content.attributes["kind"])
    if kind not in kinds():
        raise ForeignFile(
            f"{str(path)!r} holds a result of the kind {kind!r}; known are: {', '.join(kinds())}"
        )
    return read_as(presentation(kind).result, content, path)


def show(result: Record, console: Console | None = None) -> None:
    """Print the report of a result."""
    presentation(result.kind).report(result, console or Console())


def pictures(result: Record) -> Mapping[str, Draw]:
    """How the pictures of a result are drawn, by their names."""
    return presentation(result.kind).pictures(result)


def draw_all(result: Record, folder: str | Path) -> list[Path]:
    """Draw every picture of a result into a folder, made if need be; returns the files.

    Raises:
        OSError: if the folder or a picture cannot be written.
    """
    drawn = []
    for path, failure in draw_each(partial(pictures, result), Path(folder)):
        if failure is not None:
            raise failure
        drawn.append(path)
    return drawn


def draw_each(
    found: Callable[[], Mapping[str, Draw]], folder: Path
) -> Iterator[tuple[Path, Exception | None]]:
    """Draw every picture, also where others fail: each path, and what went wrong with it."""
    try:
        named = found()
        folder.mkdir(parents=True, exist_ok=True)
    except Exception as error:  # whatever a picture's library finds on this machine
        yield folder, error
        return
    for name, draw in named.items():
        path = folder / f"{name}.png"
        try:
            draw_file(draw, path)
        except Exception as error:  # as above: a result must not be lost for a picture
            yield path, error
        else:
            yield path, None
