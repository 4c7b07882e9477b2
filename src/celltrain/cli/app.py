"""The commands and their options, and what the exit status says.

0: done; 2: bad input, with a message and nothing written; 3: the steady train did not converge,
with its history, the last state saved, or cases of a study failed; 4: the workers of a study were
lost; 130: interrupted.

Commands are imported when they are run, so that help and bad input need not wait for them.
"""

from collections.abc import Sequence
from importlib.metadata import version

from cyclopts import App, CycloptsError
from rich.console import Console

from celltrain.cli.failure import CommandFailed
from celltrain.parameters import CaseError

BAD_INPUT = 2
INTERRUPTED = 130

#: Command -> its function and the first line of that function's docstring.
COMMANDS = {
    "base": ("base:base", "Compute the steady train alone."),
    "branch": ("branch:branch", "Follow the steady trains along a parameter, through folds."),
    "case": (
        "case:case",
        "Print the complete case as TOML, dimensionless: what a computation would use.",
    ),
    "evolve": (
        "evolve:evolve",
        "Simulate a disturbed train; the file may be read, the simulation killed and gone on with.",
    ),
    "paper": (
        "paper:paper",
        "Compute or resume one of the paper's figures, draw it, and check the paper's statements.",
    ),
    "plot": (
        "plot:plot",
        "Draw a result or a simulation: growth beside theory, the cells at chosen times, a film.",
    ),
    "search": (
        "search:search",
        "Search for further steady trains of a case, by deflation of those that are known.",
    ),
    "sensitivity": (
        "sensitivity:sensitivity",
        "Compute how a growth rate changes with the train's parameters, and where it is made.",
    ),
    "stability": (
        "stability:stability",
        "Compute the steady train and its linear stability: growth rates, modes, transient growth.",
    ),
    "sweep": (
        "sweep:sweep",
        "Run or resume a study: the stability of trains over ranges of their parameters.",
    ),
    "transient": (
        "transient:transient",
        "Compute the transient growth of disturbances: how much, when, and of which.",
    ),
}

app = App(
    name="celltrain",
    help="Trains of red blood cells in narrow tubes: the steady train, and whether it is stable.",
    version=lambda: f"celltrain {version('celltrain')}",
    result_action="return_value",
    suppress_keyboard_interrupt=False,
)
for name, (place, line) in COMMANDS.items():
    app.command(f"celltrain.cli.{place}", name=name, help=line)


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
    except CommandFailed as error:
        errors.print(f"celltrain: {error}", markup=False, highlight=False, soft_wrap=True)
        return error.status
    except KeyboardInterrupt as interruption:
        kept = str(interruption) or "nothing was saved"
        errors.print(f"celltrain: interrupted; {kept}", markup=False, soft_wrap=True)
        return INTERRUPTED
    return status or 0
