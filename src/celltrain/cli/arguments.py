"""Arguments that several commands take."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from celltrain.cli.options import reader

CaseFile = Annotated[Path | None, Parameter(help="TOML file of the case; options override it.")]
Json = Annotated[bool, Parameter(help="Print one JSON object and nothing else.", negative=())]
Quiet = Annotated[bool, Parameter(help="No progress on standard error.", negative=())]
Plot = Annotated[Path | None, Parameter(help="Folder for pictures; made if it is not there.")]
Output = Annotated[
    Path | None,
    Parameter(name=("--output", "-o"), help="netCDF file for the result; replaced if it exists."),
]
Start = Annotated[
    Path | None,
    Parameter(
        help="netCDF file with a result to continue from; without a case file, its case is the"
        " one that the options change."
    ),
]
Accuracy = Annotated[
    float,
    Parameter(
        help="Relative accuracy of the growth rate up to which the degree rises, if none is given;"
        " 1e-4 U/r0 are enough where that is less.",
    ),
]
Numbers = Annotated[
    list[int] | None,
    Parameter(
        consume_multiple=True,
        negative=(),
        converter=reader(int, "allowed: whole numbers from 0 to the degree"),
        help="Azimuthal numbers m to compute, such as 0 1 2; unless given, all that matter.",
    ),
]
