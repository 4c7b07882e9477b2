"""Results in files and as plain numbers: any dataclass whose fields say what they are.

What files need takes half a second to load: it is imported when it is asked for.
"""

from typing import TYPE_CHECKING

from celltrain.later import imported_later
from celltrain.results.lock import only_writer
from celltrain.results.plain import Plain, plain, summary
from celltrain.results.prepare import prepare
from celltrain.results.replace import remove_leftovers, replace_file

if TYPE_CHECKING:
    from celltrain.results.netcdf import (
        ForeignFile,
        from_dataset,
        read,
        read_dataset,
        save,
        to_dataset,
        write_dataset,
    )

__all__ = [
    "ForeignFile",
    "Plain",
    "from_dataset",
    "only_writer",
    "plain",
    "prepare",
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
        "netcdf": (
            "ForeignFile",
            "from_dataset",
            "read",
            "read_dataset",
            "save",
            "to_dataset",
            "write_dataset",
        )
    },
)
