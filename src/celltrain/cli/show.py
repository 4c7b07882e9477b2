"""The command that prints what a file holds: ``celltrain show``."""

from celltrain.cli.arguments import Json, ResultFile
from celltrain.cli.compute import print_result, read_result
from celltrain.cli.keeping import Keeper


def show(file: ResultFile, /, *, json: Json = False) -> int:
    """Print the report of a result in a file again, without computing anything."""
    keeper = Keeper()
    print_result(read_result(file, "file"), keeper, as_json=json)
    return keeper.status
