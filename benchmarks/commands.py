"""Whole commands, measured from outside: from the start of the process to its end."""

import math
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from measuring import summarised

CASE = ("--diameter", "6", "--packing", "0.2", "--cells", "8")
STABILITY = ("stability", *CASE, "--degree", "12", "--json")
# Where the folder that a command may fill goes among its arguments.
FOLDER = "{folder}"
TWO_WORKERS = ("-o", f"{FOLDER}/results", "--workers", "2", "--quiet")


@dataclass(frozen=True)
class Command:
    """Arguments of the command line, and what is there when it starts.

    `compiled` says whether what earlier runs compiled is; `repeated` that a first run goes before
    those that are measured.
    """

    arguments: Sequence[str]
    compiled: bool = True
    repeated: bool = True


COMMANDS = {
    "command": Command(STABILITY),
    "command.accurate": Command(("stability", *CASE, "--json")),
    "command.empty": Command(STABILITY, compiled=False, repeated=False),
    "command.infinite": Command(("infinite", *CASE, "--degree", "12", "--json")),
    "command.help": Command(("--help",)),
    "map": Command(("paper", "fig6", "--resolution", "paper", *TWO_WORKERS), repeated=False),
    "map.converged": Command(("paper", "fig6", *TWO_WORKERS), repeated=False),
}


def measure_command(command: Command, runs: int) -> dict[str, float]:
    """Seconds and memory of `runs` runs of a command, each in a folder of its own.

    `first_seconds` is what a first run takes beyond the others, not a number if there is none;
    `peak_mib` the largest memory of a single process.

    **Raises:** `SystemExit` with the command's messages if it fails.
    """
    if command.compiled and not command.repeated:
        # What is compiled is to be there.
        _run(Command(STABILITY))
    measured = [_run(command) for _ in range(runs + command.repeated)]
    seconds = [each[0] for each in measured]
    peak = max(each[1] for each in measured)
    if command.repeated:
        return summarised(seconds, peak)
    return {
        "seconds": statistics.median(seconds),
        "first_seconds": math.nan,
        "peak_mib": peak,
    }


def _run(command: Command) -> tuple[float, float]:
    """Seconds and MiB of one run."""
    with (
        tempfile.TemporaryDirectory() as folder,
        tempfile.TemporaryFile() as output,
        tempfile.TemporaryFile() as errors,
    ):
        arguments = [each.format(folder=folder) for each in command.arguments]
        program = f"import sys; from celltrain.cli import main; sys.exit(main({arguments!r}))"
        environment = os.environ if command.compiled else _empty_caches(folder)
        begin = time.perf_counter()
        process = subprocess.Popen(
            [sys.executable, "-c", program], stdout=output, stderr=errors, env=environment
        )
        _, status, usage = os.wait4(process.pid, 0)
        seconds = time.perf_counter() - begin
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode:
            errors.seek(0)
            raise SystemExit(f"{' '.join(arguments)} failed:\n{errors.read().decode()}")
    return seconds, usage.ru_maxrss / 1024.0


def _empty_caches(folder: str) -> Mapping[str, str]:
    """An environment in which nothing was compiled yet."""
    own = {"NUMBA_CACHE_DIR": f"{folder}/loops", "XDG_CACHE_HOME": f"{folder}/cache"}
    others = {
        name: value for name, value in os.environ.items() if name != "JAX_COMPILATION_CACHE_DIR"
    }
    return others | own
