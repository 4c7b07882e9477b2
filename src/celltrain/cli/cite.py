"""The command that says what to cite: ``celltrain cite``."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from celltrain.citation import PAPER, SOFTWARE, sources_of
from celltrain.cli.compute import read_result
from celltrain.cli.keeping import Keeper

ResultFile = Annotated[
    Path | None,
    Parameter(help="netCDF file of a result (.nc), for the sources of its methods besides."),
]


def cite(result: ResultFile = None, /) -> int:
    """Print what to cite as BibTeX: package and paper, and what a result's methods rest on."""
    sources = [SOFTWARE, PAPER]
    if result is not None:
        sources += sources_of(read_result(result, "file"))
    keeper = Keeper()
    keeper.show(lambda: print("\n\n".join(source.bibtex() for source in sources)))
    return keeper.status
