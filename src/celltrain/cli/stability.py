"""The command for linear stability: ``celltrain stability``, of N cells or of an infinite train."""

from typing import Annotated

from cyclopts import Parameter

from celltrain.cli.arguments import Accuracy, CaseFile, Json, Numbers, Output, Plot, Quiet, Start
from celltrain.cli.compute import Request, run
from celltrain.cli.infinite import run_infinite
from celltrain.cli.options import CaseOptions, given_leaves, reader
from celltrain.parameters import CaseError
from celltrain.stability import ACCURACY

ErrorBars = Annotated[
    int | None,
    Parameter(
        converter=reader(int, "allowed: whole numbers >= 1"),
        help="Give this many leading growth rates an error bar, from two higher degrees and from"
        " finer rules.",
    ),
]
Infinite = Annotated[
    bool,
    Parameter(
        negative=(),
        help="Of a train of infinitely many cells: growth rates of waves of any length, m = 0 to 3"
        " if none are given, and the most unstable wave.",
    ),
]
Phases = Annotated[
    list[float] | None,
    Parameter(
        name="--phase",
        consume_multiple=True,
        negative=(),
        converter=reader(float, "allowed: 0, and numbers from 0.001 to pi"),
        help="Phases q from cell to cell of an infinite train (radians, 0 or from 0.001 to pi); 17"
        " in equal steps if not given.",
    ),
]


def stability(
    case: CaseFile = None,
    /,
    *,
    options: CaseOptions = None,
    infinite: Infinite = False,
    phases: Phases = None,
    azimuthal_numbers: Numbers = None,
    error_bars: ErrorBars = None,
    accuracy: Accuracy = ACCURACY,
    start: Start = None,
    output: Output = None,
    plot: Plot = None,
    json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Compute the steady train and its linear stability: growth rates, modes, transient growth."""
    request = Request(case, start, output, plot, json, quiet)
    leaves = given_leaves(options)
    if infinite:
        if error_bars is not None:
            raise CaseError("error_bars is not allowed with infinite: it is for a train of N cells")
        return run_infinite(request, leaves, phases, azimuthal_numbers, accuracy)
    if phases is not None:
        raise CaseError("phase is not allowed without infinite: N cells have q = 2 pi j/N")
    return run(
        request,
        leaves,
        stable=True,
        azimuthal_numbers=azimuthal_numbers,
        error_bars=error_bars,
        accuracy=accuracy,
    )
