"""What the parts cost: seconds and peak memory, beside what they may take and took before.

The case is the one of `make demo`: diameter 6, packing 0.2, eight cells, degree 12. Every stage
runs in a process of its own, with what is compiled kept as it is; what the first call takes beyond
the others stands apart. Whole commands are measured from outside, after one run that fills the
caches, or with empty ones. Each measurement becomes a line of results.csv beside this script. The
paper's maps are left out unless asked for.

    python benchmarks/run.py [--quick] [--maps] [--only NAME ...]

Run time. About five minutes on two cores, with --quick about three, with --maps five more, with
nothing else to do.
"""

import argparse
import csv
import json
import math
import os
import subprocess
import sys
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from commands import COMMANDS, measure_command
from measuring import HERE, describe_version, processor
from rich.console import Console
from rich.table import Table

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
# What a whole command, or a stage without JAX, may take, MiB.
MEMORY = 500.0


@dataclass(frozen=True)
class Case:
    """One thing measured; seconds and MiB that it may take, and what it took before.

    `stages` is the script that has it as a stage; whole commands have none. A map is measured only
    if it is asked for.
    """

    name: str
    description: str
    runs: int
    bound: float | None = None
    former: str = ""
    bound_mib: float | None = None
    stages: str | None = None
    is_map: bool = False


def _command(
    name: str, description: str, runs: int, bound: float | None = None, former: str = ""
) -> Case:
    return Case(name, description, runs, bound, former, MEMORY)


def _map(name: str, description: str, bound: float, former: str = "") -> Case:
    return Case(name, description, 1, bound, former, is_map=True)


def _meridian(
    name: str, description: str, runs: int, bound: float | None = None, former: str = ""
) -> Case:
    return Case(name, description, runs, bound, former, MEMORY, "meridian_stages.py")


def _operator(
    name: str,
    description: str,
    runs: int,
    former: str,
    bound: float | None = None,
    bound_mib: float | None = None,
) -> Case:
    return Case(name, description, runs, bound, former, bound_mib, "operator_stages.py")


CASES = (
    _command("command", "celltrain stability, degree 12", 5, 2.0, "38"),
    _command("command.accurate", "  to an accuracy of 1 %", 5, 4.0),
    _command("command.empty", "  degree 12, nothing compiled", 2, 15.0, "110"),
    _command("command.infinite", "celltrain infinite, degree 12", 5),
    _command("command.help", "celltrain --help", 5, 0.5),
    _meridian("base", "steady train from rest", 5, None, "4.9"),
    _meridian("base.24", "  degree 24", 3),
    _meridian("newton", "one of Newton's iterations", 7),
    _meridian("newton.24", "  degree 24", 7),
    _meridian("blocks", "all blocks A_m(q)", 7, 0.1, "4.2; paper 5 h"),
    _meridian("blocks.24", "  degree 24", 5, 0.3),
    _meridian("blocks.48", "  degree 48", 3),
    _meridian("blocks.viscous", "  viscosity ratio 5", 7, 0.5),
    _meridian("spectrum", "spectra, numerical abscissas", 7, None, "0.13"),
    _meridian("spectrum.24", "  degree 24", 5),
    _meridian("infinite", "infinite train: 17 phases, m = 0 to 3", 5, 0.5, "17"),
    _operator("evaluation", "one velocity evaluation", 7, "0.18", 0.1, 2048.0),
    _operator("evaluation.forces", "  membrane forces", 7, "0.006"),
    _operator("evaluation.own_surface", "  own surfaces", 7, "0.051"),
    _operator("evaluation.far_analyse", "  far sum, to modes", 7, "0.030"),
    _operator("evaluation.far_synthesise", "  far sum, to points", 7, "0.024"),
    _operator("evaluation.far_at_wall", "  far sum, to the wall's points", 7, "with those"),
    _operator("evaluation.near_wall", "  near sum on the wall", 7, "0.025"),
    _operator("evaluation.near_cells", "  near sum on the cells", 7, "0.001"),
    _operator("evaluation.wall_flow", "  flow from the wall", 7, "0.026"),
    _operator("viscous", "the same at viscosity ratio 5", 5, "1.2", 0.5),
    _operator("dense.ordinary", "packing 0.7, off the axis, no close rule", 5, "0.17"),
    _operator("dense.close", "  with it", 5, "0.16"),
    _map("map", "celltrain paper fig6: 77 trains, degree 12", 60.0, "174 min"),
    _map("map.converged", "  converged to 1 %", 240.0),
)

# Stages whose times are compared: what for, with it and without it, at most how much.
RATIOS = (
    ("viscosity ratio 5", "viscous", "evaluation", 4.0),
    ("close rule", "dense.close", "dense.ordinary", 2.0),
)


def measure_stage(case: Case, stages: Path, runs: int) -> dict[str, float]:
    """Run a stage in a process of its own."""
    finished = subprocess.run(
        [sys.executable, str(stages), case.name, str(runs)],
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


def measure(case: Case, runs: int) -> dict[str, float]:
    """Seconds, what the first call took beyond that (maybe not a number), and MiB."""
    if case.stages is None:
        return measure_command(COMMANDS[case.name], runs)
    return measure_stage(case, HERE / case.stages, runs)


def record(case: Case, measured: dict[str, float], runs: int) -> None:
    """Append one line to the table of results."""
    line = {
        "date": datetime.now(UTC).strftime("%Y-%m-%d"),
        "version": describe_version(),
        "processor": processor(),
        "cores": len(os.sched_getaffinity(0)),
        "case": case.name,
        "seconds": f"{measured['seconds']:.4g}",
        "first_seconds": _or_nothing(measured["first_seconds"], ".3g"),
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
    """All measurements beside what they may take."""
    table = Table(
        title="D = 6 r0, packing 0.2, N = 8, M = 12 unless said otherwise", title_justify="left"
    )
    table.caption = (
        "before: with one operator for cells of any shape, where the command took 1.5 GiB;"
        " first +: the first call beyond the others"
    )
    table.add_column("what", no_wrap=True)
    for column in ("s", "may take", "before", "first +", "MiB", "may take"):
        table.add_column(column, justify="right", no_wrap=True)
    for case, measured in measurements:
        missed = case.bound is not None and measured["seconds"] > case.bound
        large = case.bound_mib is not None and measured["peak_mib"] > case.bound_mib
        table.add_row(
            case.description,
            _colored(f"{measured['seconds']:.3g}", missed),
            "" if case.bound is None else f"{case.bound:g}",
            case.former,
            _or_nothing(measured["first_seconds"], ".1f"),
            _colored(f"{measured['peak_mib']:.0f}", large),
            "" if case.bound_mib is None else f"{case.bound_mib:g}",
        )
    return table


def ratios(measurements: list[tuple[Case, dict[str, float]]]) -> list[str]:
    """What the viscosity ratio and the close rule cost, of those that were measured."""
    seconds = {case.name: measured["seconds"] for case, measured in measurements}
    return [
        f"{name}: {seconds[with_it] / seconds[without]:.2g} times as much (may take: {most:g})"
        for name, with_it, without, most in RATIOS
        if {with_it, without} <= set(seconds)
    ]


def _or_nothing(number: float, form: str) -> str:
    return "" if math.isnan(number) else format(number, form)


def _colored(text: str, bad: bool) -> str:
    return f"[red]{text}[/red]" if bad else text


def main() -> None:
    parser = argparse.ArgumentParser(description="What the parts of celltrain cost.")
    parser.add_argument("--quick", action="store_true", help="fewer runs; nothing is recorded")
    parser.add_argument("--maps", action="store_true", help="the paper's maps, too: minutes each")
    parser.add_argument("--only", nargs="+", metavar="NAME", choices=[case.name for case in CASES])
    options = parser.parse_args()
    chosen = [
        case
        for case in CASES
        if (case.name in options.only if options.only else options.maps or not case.is_map)
    ]
    errors = Console(stderr=True)
    measurements = []
    for number, case in enumerate(chosen, 1):
        runs = 1 if options.quick else case.runs
        with errors.status(f"{number}/{len(chosen)} {case.name}"):
            measured = measure(case, runs)
        measurements.append((case, measured))
        if not options.quick:
            record(case, measured, runs)
        if not errors.is_terminal:
            errors.print(f"{number}/{len(chosen)} {case.name}: {measured['seconds']:.3g} s")
    # Not cut to the 80 columns of a log.
    output = Console()
    output = output if output.is_terminal else Console(width=120)
    output.print(report(measurements))
    for line in ratios(measurements):
        output.print(line, highlight=False)


if __name__ == "__main__":
    main()
