"""The command that makes a page of one file: ``celltrain page``."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from celltrain.cli.arguments import Quiet, ResultFile
from celltrain.cli.compute import read_result
from celltrain.cli.keeping import Keeper
from celltrain.cli.outputs import check_output
from celltrain.cli.progress import Reporter
from celltrain.extras import check_installed

PageFile = Annotated[
    Path | None,
    Parameter(
        name=("--output", "-o"),
        help="The page, replaced if it exists; beside the file and named as it unless given.",
    ),
]


def page(result: ResultFile, /, *, output: PageFile = None, quiet: Quiet = False) -> int:
    """Write a result as one page that opens in any browser, without Python or a network."""
    check_installed("explore")
    path = result.with_suffix(".html") if output is None else output
    check_output(path)
    content = read_result(result, "file")
    with Reporter(quiet=quiet) as reporter:
        reporter.log(f"page of a result of the kind {content.kind}")
        from celltrain.explore.page import page_of

        text = page_of(content, name=result.name)
    keeper = Keeper(quiet=quiet, listed=True)
    keeper.text(path, text)
    return keeper.status
