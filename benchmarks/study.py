"""What a second worker brings: one study, computed by one process and by two.

The study is a map of four diameters by two packings at degree 8, base flow and stability of eight
cells each. Every run begins with an empty folder of results. It is measured with an empty
compilation cache, when two workers compile some programs twice, and with the programs of that run,
as in all later studies. Each run becomes a line of study.csv; what is printed is the ratio of the
medians, and how long the workers took to start.

    python benchmarks/study.py [--repeat TIMES] [--kept FOLDER]

Run time. About twenty minutes on two cores, with nothing else to do; half of that with a folder of
compiled programs (`--kept`), when no run begins without them.
"""

import argparse
import csv
import os
import statistics
import tempfile
import time
from collections import defaultdict
from datetime import UTC, datetime
from pathlib import Path

from rich.console import Console
from rich.table import Table
from run import describe_version, processor

RESULTS = Path(__file__).resolve().parent / "study.csv"
COLUMNS = (
    "date",
    "version",
    "processor",
    "cores",
    "workers",
    "programs",
    "start",
    "seconds",
    "cases",
)
WORKERS = (1, 2)
# Two workers are to finish a study at least this many times as fast as one.
TARGET = 1.6
STUDY = {
    "title": "benchmark",
    "case": {"cells": 8, "degree": 8},
    "axes": {"diameter": [7.0, 8.0, 9.0, 10.0], "packing": [0.3, 0.6]},
}


def measure(count: int, programs: Path) -> tuple[float, float]:
    """Seconds until the workers stand ready, and from then until the study is finished."""
    from celltrain.study import StabilityOfCase, local_workers, make_study, run_study

    study = make_study(STUDY)
    with tempfile.TemporaryDirectory() as folder:
        # Inherited by the workers.
        os.environ["JAX_COMPILATION_CACHE_DIR"] = str(programs)
        cases = Path(folder) / "cases"
        cases.mkdir()
        begin = time.perf_counter()
        with local_workers(count) as workers:
            ready = time.perf_counter()
            computation = StabilityOfCase(study.computed)
            records = run_study(study, cases, computation, workers.executor, workers.slots)
            done = time.perf_counter()
    failed = [record.reason for record in records.values() if record.status != "finished"]
    if failed:
        raise SystemExit(f"a case failed: {failed[0]}")
    return ready - begin, done - ready


def main() -> None:
    """Measure, print, and append to study.csv."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--repeat", type=int, default=2, help="runs with each number of workers")
    parser.add_argument("--kept", type=Path, help="folder of programs compiled in earlier runs")
    options = parser.parse_args()
    if options.kept is not None and not any(options.kept.glob("*-cache")):
        parser.error(f"--kept {options.kept}: there are no compiled programs")
    seconds: dict[tuple[int, str], list[tuple[float, float]]] = defaultdict(list)

    def run(count: int, programs: Path, kind: str) -> None:
        seconds[count, kind].append(measure(count, programs))
        append(count, kind, seconds[count, kind][-1])

    with tempfile.TemporaryDirectory() as folder:
        kept = options.kept
        if kept is None:
            for count in WORKERS:
                kept = Path(folder) / str(count)
                run(count, kept, "none")
        for _ in range(options.repeat):
            for count in WORKERS:
                run(count, kept, "kept")
    console = Console()
    table = Table("workers", "programs", "start, s", "study, s", title="8 cases, degree 8")
    medians = {}
    for which, found in seconds.items():
        start, medians[which] = (statistics.median(each) for each in zip(*found, strict=True))
        table.add_row(str(which[0]), which[1], f"{start:.1f}", f"{medians[which]:.1f}")
    console.print(table)
    for kind in dict.fromkeys(kind for _, kind in seconds):
        ratio = medians[1, kind] / medians[2, kind]
        console.print(f"two workers, programs {kind}: {ratio:.2f} times as fast (aim: {TARGET:g})")


def append(count: int, programs: str, seconds: tuple[float, float]) -> None:
    """Add a line to study.csv."""
    new = not RESULTS.exists()
    place = (datetime.now(UTC).date(), describe_version(), processor(), os.cpu_count())
    with RESULTS.open("a", newline="") as file:
        writer = csv.writer(file)
        if new:
            writer.writerow(COLUMNS)
        writer.writerow((*place, count, programs, *(f"{each:.4g}" for each in seconds), 8))


if __name__ == "__main__":
    main()
