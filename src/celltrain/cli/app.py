"""The commands and their options, and what the exit status says.

0: done; 2: bad input, with a message and nothing written; 3: the steady train did not converge,
with its history, the last state saved, or cases of a study failed; 4: something was lost: a file or
picture that was asked for, or standard output, could not be written (what can be kept is), the
memory was not enough, or the workers of a study went away; 130 or 143: interrupted by SIGINT
(Ctrl-C) or SIGTERM.

Commands are imported when they are run, so that help and bad input need not wait for them.
"""

from collections.abc import Sequence
from pathlib import Path

from cyclopts import App, CycloptsError

from celltrain.cli.keeping import reason, say
from celltrain.contract.catalogue import TAKEN, first_line, first_lines
from celltrain.contract.status import ComputationFailed, ExitStatus
from celltrain.environment import UnsuitableSetting
from celltrain.extras import MissingExtra
from celltrain.parameters import CaseError
from celltrain.version import __version__


def _commands() -> dict[str, tuple[str, str]]:
    """Every command by its name: its function, and the first line of that one's docstring."""
    here = Path(__file__)
    found = {
        name: (f"{name}:{name}", first_line(here.with_name(f"{name}.py"), name)) for name in TAKEN
    }
    found |= {name: (f"computations:{name}", line) for name, line in first_lines().items()}
    return dict(sorted(found.items()))


COMMANDS = _commands()
app = App(
    name="celltrain",
    help="Trains of red blood cells in narrow tubes: the steady train, and whether it is stable.",
    version=f"celltrain {__version__}",
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
    try:
        return app(arguments, exit_on_error=False, print_error=False) or ExitStatus.DONE
    except (CaseError, CycloptsError, UnsuitableSetting) as error:
        status, words = ExitStatus.BAD_INPUT, str(error).replace(". Choose from: ", "; allowed: ")
    except ComputationFailed as error:
        status, words = error.status, str(error)
    except ImportError as error:
        # A command's own import arrives wrapped.
        missing = error if isinstance(error, MissingExtra) else error.__cause__
        if not isinstance(missing, MissingExtra):
            raise
        status, words = ExitStatus.BAD_INPUT, str(missing)
    except OSError as error:
        status = ExitStatus.NOT_KEPT
        words = f"{error.filename or 'standard output'} cannot be used: {reason(error)}"
    except MemoryError as error:
        status = ExitStatus.NOT_KEPT
        words = f"the memory is not enough: {error}" if str(error) else "the memory is not enough"
    say(f"celltrain: {words}")
    return status
