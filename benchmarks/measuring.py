"""What every benchmark needs: seconds and memory of a piece of work, and where it was measured."""

import contextlib
import json
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent

Work = Callable[[], Any]


def peak_mib() -> float:
    """Largest resident memory of this process since the last reset, MiB."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmHWM:"):
            return float(line.split()[1]) / 1024.0
    return float("nan")


def reset_peak() -> None:
    """Let the largest resident memory start again from what is resident now."""
    # Where the kernel refuses, the peak is that of the whole process: an upper bound.
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")


def measure(work: Work, runs: int) -> dict[str, float]:
    """Seconds and memory of `runs` runs after a first one.

    `seconds` is the median of the runs, `first_seconds` what the first one took beyond that:
    compiling, loading what is compiled, tables that are kept. `peak_mib` is the largest resident
    memory of the process meanwhile, its libraries included.
    """
    reset_peak()
    seconds = []
    for _ in range(runs + 1):
        begin = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - begin)
    return summarised(seconds, peak_mib())


def summarised(seconds: list[float], peak: float) -> dict[str, float]:
    """The measurement that a first run and others make."""
    median = statistics.median(seconds[1:])
    return {
        "seconds": median,
        "first_seconds": max(seconds[0] - median, 0.0),
        "peak_mib": peak,
    }


def run_stage(stages: Mapping[str, Callable[[], Work]]) -> None:
    """Measure the stage that the command line names, NAME RUNS; print it as one JSON object.

    **Arguments:** `stages`: name -> what makes it ready and returns the work to measure.
    """
    name, runs = sys.argv[1:3]
    print(json.dumps(measure(stages[name](), int(runs))))


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
