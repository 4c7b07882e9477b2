"""The commands and their options, and what the exit status says.

0: done; 2: bad input, with a message and nothing written; 3: the steady train did not converge,
with its history, the last state saved, or cases of a study failed; 4: the workers of a study were
lost; 130: interrupted.
"""

import sys
from collections.abc import Sequence
from importlib.metadata import version

from cyclopts import App, CycloptsError
from rich.console import Console

from celltrain.cli.arguments import CaseFile, Json, Output, Plot, Quiet, Start
from celltrain.cli.branch import branch
from celltrain.cli.compute import Request, run
from celltrain.cli.evolve import evolve
from celltrain.cli.options import CaseOptions, given_leaves
from celltrain.cli.paper import paper
from celltrain.cli.plot import plot as plot_
from celltrain.cli.search import search
from celltrain.cli.sensitivity import sensitivity
from celltrain.cli.stability import stability
from celltrain.cli.sweep import sweep
from celltrain.cli.transient import transient
from celltrain.parameters import CaseError, merge_case, read_case
from celltrain.study import WorkersLost

BAD_INPUT = 2
WORKERS_LOST = 4
INTERRUPTED = 130

app = App(
    name="celltrain",
    help="Trains of red blood cells in narrow tubes: the steady train, and whether it is stable.",
    version=lambda: f"celltrain {version('celltrain')}",
    result_action="return_value",
    suppress_keyboard_interrupt=False,
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line (``sys.argv`` unless given) and return the exit status.

    Bad input, a failure to converge and an interruption end in a message on standard error.
    """
    errors = Console(stderr=True)
    try:
        status = app(arguments, exit_on_error=False, print_error=False)
    except (CaseError, CycloptsError) as error:
        errors.print(f"celltrain: {error}", markup=False, highlight=False, soft_wrap=True)
        return BAD_INPUT
    except WorkersLost as error:
        errors.print(f"celltrain: {error}", markup=False, highlight=False, soft_wrap=True)
        return WORKERS_LOST
    except KeyboardInterrupt as interruption:
        kept = str(interruption) or "nothing was saved"
        errors.print(f"celltrain: interrupted; {kept}", markup=False, soft_wrap=True)
        return INTERRUPTED
    return status or 0


app.command(branch)
app.command(evolve)
app.command(plot_, name="plot")
app.command(search)
app.command(sensitivity)
app.command(paper)
app.command(stability)
app.command(sweep)
app.command(transient)


@app.command
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
    """Compute the steady train alone."""
    return run(Request(case, start, output, plot, json, quiet), given_leaves(options), stable=False)


@app.command(name="case")
def case_(case: CaseFile = None, /, *, options: CaseOptions = None) -> int:
    """Print the complete case as TOML, dimensionless: what a computation would use."""
    train = merge_case(read_case(case) if case else {}, given_leaves(options))
    sys.stdout.write(train.to_toml())
    return 0
