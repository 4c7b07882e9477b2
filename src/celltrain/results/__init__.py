"""Results in files and as plain numbers: any dataclass whose fields say what they are.

What files need is imported when it is asked for, and xarray, which takes long to load, only with
its data sets.
"""

from typing import TYPE_CHECKING

from celltrain.later import imported_later
from celltrain.results.lock import only_writer
from celltrain.results.plain import Plain, plain, summary
from celltrain.results.replace import remove_leftovers, replace_file

if TYPE_CHECKING:
    from celltrain.results.labelled import from_dataset, read_dataset, to_dataset, write_dataset
    from celltrain.results.netcdf import ForeignFile, read, save

__all__ = [
    "ForeignFile",
    "Plain",
    "from_dataset",
    "only_writer",
    "plain",
    "read",
    "read_dataset",
    "remove_leftovers",
    "replace_file",
    "save",
    "summary",
    "to_dataset",
    "write_dataset",
]

__getattr__ = imported_later(
    __name__,
    {
        "labelled": ("from_dataset", "read_dataset", "to_dataset", "write_dataset"),
        "netcdf": ("ForeignFile", "read", "save"),
    },
)
