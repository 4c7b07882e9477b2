"""What a case is: the tube, the cell, the flow, the train and the resolution, as frozen objects.

A :class:`Train` is checked when it is made, so that everything that receives one may rely on it.
Every number in it is a *leaf* with a name of its own (``diameter``, ``packing``, ``degree``, ...),
and Python, case files and the command line all go through the same routing of leaves into sections.
"""

from celltrain.parameters.case import load_case, merge_case, read_case
from celltrain.parameters.errors import CaseError
from celltrain.parameters.resolution import Resolution, Sizes
from celltrain.parameters.scales import Scales
from celltrain.parameters.sections import Cell, Flow, Tube
from celltrain.parameters.train import Train
from celltrain.parameters.units import PaperUnits, paper_units
from celltrain.parameters.usual import UnusualCase, check_volume, relative_volume

__all__ = [
    "CaseError",
    "Cell",
    "Flow",
    "PaperUnits",
    "Resolution",
    "Scales",
    "Sizes",
    "Train",
    "Tube",
    "UnusualCase",
    "check_volume",
    "load_case",
    "merge_case",
    "paper_units",
    "read_case",
    "relative_volume",
]
