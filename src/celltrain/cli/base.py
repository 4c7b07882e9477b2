"""The command for steady trains: ``celltrain base``."""

from celltrain.cli.arguments import CaseFile, Json, Output, Plot, Quiet, Start
from celltrain.cli.compute import Request, run
from celltrain.cli.options import CaseOptions, given_leaves


def base(
    case: CaseFile = None,
    /,
    *,
    options: CaseOptions = None,
    start: Start = None,
    output: Output = None,
    plot: Plot = None,
    json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Compute the steady train alone.

    Without a degree it rises until the cells' velocity is known to 1e-4 U.
    """
    return run(Request(case, start, output, plot, json, quiet), given_leaves(options), stable=False)
