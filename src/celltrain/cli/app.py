"""The commands and their options, and what the exit status says.

0: done; 2: bad input, with a message and nothing written; 3: the steady train did not converge,
with its history, the last state saved, or cases of a study failed; 4: something was lost: a file or
picture that was asked for, or standard output, could not be written (what can be kept is), the
memory was not enough, or the workers of a study went away; 130 or 143: interrupted by SIGINT
(Ctrl-C) or SIGTERM.

Commands are imported when they are run, so that help and bad input need not wait for them.
"""

from collections.abc import Sequence
from importlib.metadata import version

from cyclopts import App, CycloptsError
from rich.console import Console

from celltrain.cli.keeping import reason
from celltrain.contract.catalogue import first_lines
from celltrain.contract.status import ComputationFailed, ExitStatus
from celltrain.environment import UnsuitableSetting
from celltrain.extras import MissingExtra
from celltrain.parameters import CaseError

#: Commands that are no analyses: function, and the first line of that function's docstring.
OTHERS = {
    "case": (
        "case:case",
        "Print the complete case as TOML, dimensionless: what a computation would use.",
    ),
    "cite": (
        "cite:cite",
        "Print what to cite as BibTeX: package and paper, and what a result's methods rest on.",
    ),
    "explore": (
        "explore:explore",
        "Open a train in the browser: sliders, the cells in three dimensions, spectrum and modes.",
    ),
    "page": (
        "page:page",
        "Write a result as one page that opens in any browser, without Python or a network.",
    ),
    "paper": (
        "paper:paper",
        "Compute or resume one of the paper's figures, draw it, and check the paper's statements.",
    ),
    "plot": ("plot:plot", "Draw what a file holds: any result, a simulation, its film."),
    "show": (
        "show:show",
        "Print the report of a result in a file again, without computing anything.",
    ),
    "sweep": (
        "sweep:sweep",
        "Run or resume a study: trains over ranges or distributions of parameters.",
    ),
}
#: Every command: its function, and its line of help.
COMMANDS = dict(
    sorted(
        (
            OTHERS | {name: (f"computations:{name}", line) for name, line in first_lines().items()}
        ).items()
    )
)

app = App(
    name="celltrain",
    help="Trains of red blood cells in narrow tubes: the steady train, and whether it is stable.",
    version=lambda: f"celltrain {version('celltrain')}",
    result_action="return_value",
    suppress_keyboard_interrupt=False,
)
for name, (place, line) in COMMANDS.items():
    app.command(f"celltrain.cli.{place}", name=name, help=line)


def run(arguments: Sequence[str] | None = None) -> int:
    """Run the command line (``sys.argv`` unless given) and return the exit status.

    Bad input and failures end in a message on standard error.

    Raises:
        KeyboardInterrupt: with what was saved, in words.
    """
    errors = Console(stderr=True)
    try:
        status = app(arguments, exit_on_error=False, print_error=False)
    except (CaseError, CycloptsError) as error:
        words = str(error).replace(". Choose from: ", "; allowed: ")
        errors.print(f"celltrain: {words}", markup=False, highlight=False, soft_wrap=True)
        return ExitStatus.BAD_INPUT
    except ComputationFailed as error:
        errors.print(f"celltrain: {error}", markup=False, highlight=False, soft_wrap=True)
        return error.status
    except UnsuitableSetting as error:
        errors.print(f"celltrain: {error}", markup=False, highlight=False, soft_wrap=True)
        return ExitStatus.BAD_INPUT
    except ImportError as error:
        # A command's own import arrives wrapped.
        missing = error if isinstance(error, MissingExtra) else error.__cause__
        if not isinstance(missing, MissingExtra):
            raise
        errors.print(f"celltrain: {missing}", markup=False, highlight=False, soft_wrap=True)
        return ExitStatus.BAD_INPUT
    except OSError as error:
        words = f"{error.filename or 'standard output'} cannot be used: {reason(error)}"
        errors.print(f"celltrain: {words}", markup=False, highlight=False, soft_wrap=True)
        return ExitStatus.NOT_KEPT
    except MemoryError as error:
        words = f"the memory is not enough: {error}" if str(error) else "the memory is not enough"
        errors.print(f"celltrain: {words}", markup=False, highlight=False, soft_wrap=True)
        return ExitStatus.NOT_KEPT
    return status or 0
