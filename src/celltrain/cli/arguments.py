"""Arguments that several commands take."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

CaseFile = Annotated[
    Path | None,
    Parameter(
        help="TOML file of the case, or netCDF file of a result (.nc), whose case and steady train"
        " are taken; options override the case."
    ),
]
ResultFile = Annotated[
    Path,
    Parameter(
        help="netCDF file of a result or of a simulation, also of one that is under way (.nc)."
    ),
]
Json = Annotated[bool, Parameter(help="Print one JSON object and nothing else.", negative=())]
Quiet = Annotated[bool, Parameter(help="No progress on standard error.", negative=())]
Plot = Annotated[Path | None, Parameter(help="Folder for pictures; made if it is not there.")]
Output = Annotated[
    Path | None,
    Parameter(name=("--output", "-o"), help="netCDF file for the result; replaced if it exists."),
]
#: Of what is written while it is computed.
OwnOutput = Annotated[
    Path | None,
    Parameter(
        name=("--output", "-o"),
        help="netCDF file that is written meanwhile; one that exists is not replaced unasked.",
    ),
]
Start = Annotated[
    Path | None,
    Parameter(
        help="netCDF file with a result to continue from; without a case file, its case is the"
        " one that the options change."
    ),
]
