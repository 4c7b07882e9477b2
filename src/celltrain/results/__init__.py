"""Results: the registry of quantities, files, summaries for programs, reports for people.

What files need takes half a second to load: it is imported when it is asked for.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from celltrain.results.registry import QUANTITIES, Quantity, attributes, print_registry, quantity
from celltrain.results.replace import remove_leftovers, replace_file
from celltrain.results.report import print_report, verdict
from celltrain.results.summary import summary

if TYPE_CHECKING:
    from celltrain.results.netcdf import dataset, load, reading, save

__all__ = [
    "QUANTITIES",
    "Quantity",
    "attributes",
    "dataset",
    "load",
    "print_registry",
    "print_report",
    "quantity",
    "reading",
    "remove_leftovers",
    "replace_file",
    "save",
    "summary",
    "verdict",
]

_OF_FILES = ("dataset", "load", "reading", "save")


def __getattr__(name: str) -> object:
    if name not in _OF_FILES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.netcdf"), name)
