"""What a second worker brings: one study, computed by one process and by two.

The study is a map of seven diameters by six packings at degree 12, base flow and stability of eight
cells each. Every run begins with an empty folder of results. It is measured with nothing compiled,
when two workers compile the same loops twice, and with the loops of that run, as in all later
studies. Each run becomes a line of study.csv; what is printed is the ratio of the medians, and how
long the workers took to start.

    python benchmarks/study.py [--repeat TIMES] [--kept FOLDER]

Run time. About five minutes on two cores, with nothing else to do; less with a folder of compiled
loops (`--kept`), when no run begins without them.
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

from measuring import describe_version, processor
from rich.console import Console
from rich.table import Table

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
    "case": {"cells": 8, "degree": 12},
    "axes": {
        "diameter": {"from": 6, "to": 12, "points": 7},
        "packing": {"from": 0.2, "to": 0.7, "points": 6},
    },
}


def measure(count: int, loops: Path) -> tuple[float, float, int]:
    """Seconds until the workers stand ready, and from then for the study; how many cases it has."""
    from celltrain.study import StabilityOfCase, local_workers, make_study, run_study

    study = make_study(STUDY)
    with tempfile.TemporaryDirectory() as folder:
        # Inherited by the workers.
        os.environ["NUMBA_CACHE_DIR"] = str(loops)
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
    return ready - begin, done - ready, len(records)


def main() -> None:
    """Measure, print, and append to study.csv."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--repeat", type=int, default=2, help="runs with each number of workers")
    parser.add_argument("--kept", type=Path, help="folder of loops compiled in earlier runs")
    options = parser.parse_args()
    if options.kept is not None and not any(options.kept.rglob("*.nbi")):
        parser.error(f"--kept {options.kept}: there are no compiled loops")
    seconds: dict[tuple[int, str], list[tuple[float, float]]] = defaultdict(list)

    def run(count: int, loops: Path, kind: str) -> None:
        *found, cases = measure(count, loops)
        seconds[count, kind].append((found[0], found[1]))
        append(count, kind, seconds[count, kind][-1], cases)

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
    table = Table("workers", "loops", "start, s", "study, s", title="42 cases, degree 12")
    medians = {}
    for which, found in seconds.items():
        start, medians[which] = (statistics.median(each) for each in zip(*found, strict=True))
        table.add_row(str(which[0]), which[1], f"{start:.1f}", f"{medians[which]:.1f}")
    console.print(table)
    for kind in dict.fromkeys(kind for _, kind in seconds):
        ratio = medians[1, kind] / medians[2, kind]
        console.print(f"two workers, loops {kind}: {ratio:.2f} times as fast (aim: {TARGET:g})")


def append(count: int, loops: str, seconds: tuple[float, float], cases: int) -> None:
    """Add a line to study.csv."""
    new = not RESULTS.exists()
    place = (datetime.now(UTC).date(), describe_version(), processor(), os.cpu_count())
    with RESULTS.open("a", newline="") as file:
        writer = csv.writer(file)
        if new:
            writer.writerow(COLUMNS)
        writer.writerow((*place, count, loops, *(f"{each:.4g}" for each in seconds), cases))


if __name__ == "__main__":
    main()
