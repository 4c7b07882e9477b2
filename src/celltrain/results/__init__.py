"""Results: the registry of quantities, files, summaries for programs, reports for people."""

from celltrain.results.netcdf import dataset, load, reading, save
from celltrain.results.registry import QUANTITIES, Quantity, attributes, print_registry, quantity
from celltrain.results.replace import remove_leftovers, replace_file
from celltrain.results.report import print_report, verdict
from celltrain.results.summary import summary

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
