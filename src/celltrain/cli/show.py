"""The command that prints what a file holds: ``celltrain show``."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from celltrain.cli.arguments import Json
from celltrain.cli.compute import print_result, read_result
from celltrain.cli.keeping import Keeper

ResultFile = Annotated[Path, Parameter(help="netCDF file of a result (.nc).")]


def show(file: ResultFile, /, *, json: Json = False) -> int:
    """Print the report of a result in a file again, without computing anything."""
    keeper = Keeper(Console(stderr=True), quiet=True)
    print_result(read_result(file, "file"), keeper, as_json=json)
    return keeper.status
