"""What a second worker brings: one study, computed by one process and by two.

The study is a map of four diameters by two packings at degree 8, base flow and stability of eight
cells each. Every run begins with an empty folder of results and an empty compilation cache, so
that both compile all that they need; the second run is that of two workers, then each once more,
since machines are noisy. Each run becomes a line of study.csv; what is printed is the ratio of the
medians, that of the cases' own seconds, and how long the workers took to start.

    python benchmarks/study.py [--repeat TIMES]

Run time. About ten minutes on two cores, with nothing else to do.
"""

import argparse
import csv
import os
import statistics
import tempfile
import time
from datetime import UTC, datetime
from pathlib import Path

from rich.console import Console
from rich.table import Table

RESULTS = Path(__file__).resolve().parent / "study.csv"
COLUMNS = ("date", "version", "processor", "cores", "workers", "start_seconds", "seconds", "cases")
WORKERS = (1, 2)
# Two workers are to finish a study at least this many times as fast as one.
TARGET = 1.6
STUDY = {
    "title": "benchmark",
    "case": {"cells": 8, "degree": 8},
    "axes": {"diameter": [7.0, 8.0, 9.0, 10.0], "packing": [0.3, 0.6]},
}


def measure(count: int) -> tuple[float, float]:
    """Seconds until the workers stand ready, and from then until the study is finished."""
    from celltrain.study import StabilityOfCase, local_workers, make_study, run_study

    study = make_study(STUDY)
    with tempfile.TemporaryDirectory() as folder:
        # Inherited by the workers.
        os.environ["JAX_COMPILATION_CACHE_DIR"] = str(Path(folder) / "programs")
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
    from run import describe_version, processor

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--repeat", type=int, default=2, help="runs with each number of workers")
    repeat = parser.parse_args().repeat
    console = Console()
    seconds: dict[int, list[tuple[float, float]]] = {count: [] for count in WORKERS}
    new = not RESULTS.exists()
    for _ in range(repeat):
        for count in WORKERS:
            seconds[count].append(measure(count))
            with RESULTS.open("a", newline="") as file:
                writer = csv.writer(file)
                if new:
                    writer.writerow(COLUMNS)
                    new = False
                line = (f"{each:.4g}" for each in seconds[count][-1])
                place = (datetime.now(UTC).date(), describe_version(), processor(), os.cpu_count())
                writer.writerow((*place, count, *line, 8))
    table = Table("workers", "start, s", "study, s", title="a study of 8 cases, degree 8")
    medians = {}
    for count, found in seconds.items():
        start, medians[count] = (statistics.median(each) for each in zip(*found, strict=True))
        table.add_row(str(count), f"{start:.1f}", f"{medians[count]:.1f}")
    console.print(table)
    console.print(f"two workers are {medians[1] / medians[2]:.2f} times as fast (aim: {TARGET:g})")


if __name__ == "__main__":
    main()
