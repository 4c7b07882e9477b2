"""What the parts cost: seconds and peak memory, beside what they may cost.

The case is the one of `make demo`: diameter 6, packing 0.2, eight cells, degree 12. Every stage
runs in a process of its own, with JAX's compilation cache as it is; what the first call takes
beyond the others stands apart. The whole command is measured from outside, after one run that fills
the cache. Each measurement becomes a line of results.csv beside this script.

    python benchmarks/run.py [--quick] [--only NAME ...]

Run time. About seven minutes on two cores, with --quick about four, with nothing else to do.
"""

import argparse
import csv
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from rich.console import Console
from rich.table import Table

HERE = Path(__file__).resolve().parent
RESULTS = HERE / "results.csv"
COLUMNS = (
    "date",
    "version",
    "processor",
    "cores",
    "case",
    "seconds",
    "first_seconds",
    "peak_mib",
    "runs",
)
CASE = ["--diameter", "6", "--packing", "0.2", "--cells", "8", "--degree", "12"]
COMMAND = ["stability", *CASE, "--json"]


@dataclass(frozen=True)
class Case:
    """One thing measured; seconds that it may take, and that it took elsewhere."""

    name: str
    description: str
    runs: int
    target: float | None = None
    target_mib: float | None = None
    prototype: float | None = None


CASES = (
    Case("evaluation", "one velocity evaluation", 7, 0.25, 2048, 1.1),
    Case("evaluation.forces", "  membrane forces", 7),
    Case("evaluation.own_surface", "  own surfaces", 7),
    Case("evaluation.far_analyse", "  far sum, to modes", 7),
    Case("evaluation.far_synthesise", "  far sum, to points", 7),
    Case("evaluation.near_wall", "  near sum on the wall", 7),
    Case("evaluation.near_cells", "  near sum on the cells", 7),
    Case("evaluation.wall_flow", "  flow from the wall", 7),
    Case("viscous", "the same at viscosity ratio 5", 5, 1.0),
    Case("dense.ordinary", "packing 0.7, off the axis, no close rule", 5),
    Case("dense.close", "  with it", 5),
    Case("base", "steady train from rest", 3, 10.0, None, 40.0),
    Case("blocks", "all blocks A_m(q)", 3, 15.0, None, 59.0),
    Case("spectrum", "spectra, numerical abscissas", 3),
    Case("infinite", "infinite train: 17 phases, m = 0 to 3", 3, 60.0),
    Case("command", "the whole command", 3, 45.0),
)

# Stages whose times are compared: what for, with it and without it, at most how much.
RATIOS = (
    ("viscosity ratio 5", "viscous", "evaluation", 4.0),
    ("close rule", "dense.close", "dense.ordinary", 2.0),
)


def measure_stage(case: Case, runs: int) -> dict[str, float]:
    """Run a stage in a process of its own."""
    finished = subprocess.run(
        [sys.executable, str(HERE / "stages.py"), case.name, str(runs)],
        capture_output=True,
        text=True,
        check=False,
    )
    if finished.returncode:
        raise SystemExit(f"{case.name} failed:\n{finished.stderr}")
    for line in finished.stderr.splitlines():
        if line.startswith("viscosity ratio"):
            print(line, file=sys.stderr)
    measured: dict[str, float] = json.loads(finished.stdout.splitlines()[-1])
    return measured


def measure_command(runs: int) -> dict[str, float]:
    """Run the whole command, once to fill the cache and `runs` times more."""
    program = f"import sys; from celltrain.cli import main; sys.exit(main({COMMAND!r}))"
    seconds, peaks = [], []
    with tempfile.TemporaryFile() as output, tempfile.TemporaryFile() as errors:
        for _ in range(runs + 1):
            begin = time.perf_counter()
            process = subprocess.Popen(
                [sys.executable, "-c", program], stdout=output, stderr=errors
            )
            _, status, usage = os.wait4(process.pid, 0)
            seconds.append(time.perf_counter() - begin)
            process.returncode = os.waitstatus_to_exitcode(status)
            if process.returncode:
                errors.seek(0)
                raise SystemExit(f"the command failed:\n{errors.read().decode()}")
            peaks.append(usage.ru_maxrss / 1024.0)
    median = statistics.median(seconds[1:])
    return {
        "seconds": median,
        "first_seconds": max(seconds[0] - median, 0.0),
        "peak_mib": max(peaks),
    }


def describe_version() -> str:
    """The commit, or the package's version outside a repository."""
    described = subprocess.run(
        ["git", "describe", "--always", "--dirty", "--tags"],
        cwd=HERE,
        capture_output=True,
        text=True,
        check=False,
    )
    if described.returncode == 0:
        return described.stdout.strip()
    try:
        return version("celltrain")
    except PackageNotFoundError:
        return "unknown"


def processor() -> str:
    """Name of the processor."""
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return "unknown"


def record(case: Case, measured: dict[str, float], runs: int) -> None:
    """Append one line to the table of results."""
    line = {
        "date": datetime.now(UTC).strftime("%Y-%m-%d"),
        "version": describe_version(),
        "processor": processor(),
        "cores": len(os.sched_getaffinity(0)),
        "case": case.name,
        "seconds": f"{measured['seconds']:.4g}",
        "first_seconds": f"{measured['first_seconds']:.3g}",
        "peak_mib": f"{measured['peak_mib']:.0f}",
        "runs": runs,
    }
    new = not RESULTS.exists()
    with RESULTS.open("a", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        if new:
            writer.writeheader()
        writer.writerow(line)


def report(measurements: list[tuple[Case, dict[str, float]]]) -> Table:
    """All measurements beside the targets."""
    table = Table(title="D = 6 r0, packing 0.2, N = 8, M = 12", title_justify="left")
    table.caption = "prototype: its untuned predecessor; the paper: 5 hours for A with N = 8"
    table.add_column("what", no_wrap=True)
    for column in ("s", "target", "prototype", "first +", "MiB"):
        table.add_column(column, justify="right", no_wrap=True)
    for case, measured in measurements:
        missed = case.target is not None and measured["seconds"] > case.target
        large = case.target_mib is not None and measured["peak_mib"] > case.target_mib
        table.add_row(
            case.description,
            _colored(f"{measured['seconds']:.3g}", missed),
            "" if case.target is None else f"{case.target:g}",
            "" if case.prototype is None else f"{case.prototype:g}",
            f"{measured['first_seconds']:.1f}",
            _colored(f"{measured['peak_mib']:.0f}", large),
        )
    return table


def ratios(measurements: list[tuple[Case, dict[str, float]]]) -> list[str]:
    """What the viscosity ratio and the close rule cost, of those that were measured."""
    seconds = {case.name: measured["seconds"] for case, measured in measurements}
    return [
        f"{name}: {seconds[with_it] / seconds[without]:.2g} times as much (aim: {aim:g})"
        for name, with_it, without, aim in RATIOS
        if {with_it, without} <= set(seconds)
    ]


def _colored(text: str, bad: bool) -> str:
    return f"[red]{text}[/red]" if bad else text


def main() -> None:
    parser = argparse.ArgumentParser(description="What the parts of celltrain cost.")
    parser.add_argument("--quick", action="store_true", help="fewer runs; nothing is recorded")
    parser.add_argument("--only", nargs="+", metavar="NAME", choices=[case.name for case in CASES])
    options = parser.parse_args()
    chosen = [case for case in CASES if not options.only or case.name in options.only]
    errors = Console(stderr=True)
    measurements = []
    for number, case in enumerate(chosen, 1):
        runs = 1 if options.quick else case.runs
        with errors.status(f"{number}/{len(chosen)} {case.name}"):
            measured = (
                measure_command(runs) if case.name == "command" else measure_stage(case, runs)
            )
        measurements.append((case, measured))
        if not options.quick:
            record(case, measured, runs)
        if not errors.is_terminal:
            errors.print(f"{number}/{len(chosen)} {case.name}: {measured['seconds']:.3g} s")
    # Not cut to the 80 columns of a log.
    output = Console()
    output = output if output.is_terminal else Console(width=110)
    output.print(report(measurements))
    for line in ratios(measurements):
        output.print(line, highlight=False)


if __name__ == "__main__":
    main()
