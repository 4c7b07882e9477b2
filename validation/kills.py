"""Commands that are killed at random times, and what is left of their files.

    python validation/kills.py [--kills 200] [--seed 0]

`stability`, `evolve`, and `sweep` over axes and over distributions in turn, each ended by SIGKILL,
SIGTERM and SIGINT in turn, at a time drawn from the duration of the whole command. After each, a
second process opens all files that are there. A simulation and a study go on from where they were,
and are killed again, until they are complete: then they must be equal, bit for bit, to those that
were never stopped.
"""

import argparse
import collections
import random
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from celltrain.results import read_dataset

PROGRAM = "import sys; from celltrain.cli import main; sys.exit(main())"
CASE = ("--diameter", "6", "--packing", "0.3", "--cells", "2", "--degree", "6")
STUDY = """
[case]
packing = 0.3
cells = 1
degree = 6
[axes]
diameter = [5.5, 6, 6.5]
[compute]
estimate_error = false
"""
SAMPLE = """
[case]
diameter = 6
packing = 0.3
cells = 1
degree = 6
[distributions]
shear_modulus = {lognormal = {relative_deviation = 0.1}}
[sample]
points = 16
[compute]
azimuthal_numbers = [0, 1]
"""
SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
#: Seconds after a signal within which a command is to end.
SOON = 2.0
# What differs between runs of the same: when they took place.
CLOCKS = ("seconds", "wall_seconds")
# Opens every file in a folder, as a user would.
OPEN = """
import sys
from pathlib import Path
from celltrain.results import read_dataset
from celltrain.study import CaseRecord
from celltrain.study.sampling.store import draw_store
for path in Path(sys.argv[1]).rglob("*"):
    if path.name.startswith("."):
        continue
    if path.suffix == ".nc":
        read_dataset(path)
    elif path.suffix == ".sqlite":
        with draw_store(path.parent, {}) as store:
            store.records()
    elif path.suffix == ".json":
        CaseRecord.model_validate_json(path.read_bytes())
"""


@dataclass
class Job:
    """A command that writes to a folder; `again` is what goes on after a kill."""

    name: str
    first: list[str]
    again: list[str]
    folder: Path
    seconds: float = 0.0
    contents: dict[str, object] = field(default_factory=dict)

    def command(self) -> list[str]:
        """What to run now: from the beginning, or on."""
        begun = any(each.suffix == ".nc" for each in self.folder.rglob("*.nc"))
        return self.again if begun else self.first

    def clear(self) -> None:
        """Begin from nothing."""
        for path in self.folder.iterdir():
            path.unlink()

    def read(self) -> dict[str, object]:
        """Everything in the files but times."""
        found: dict[str, object] = {}
        for path in sorted(self.folder.rglob("*.nc")):
            data = read_dataset(path)
            for name, each in data.variables.items():
                if not any(clock in str(name) for clock in CLOCKS):
                    found[f"{path.name}/{name}"] = each.values
        return found


def jobs(folder: Path) -> list[Job]:
    for name in ("stability", "evolve", "sweep", "sample"):
        (folder / name).mkdir()
    study = folder / "study.toml"
    study.write_text(STUDY)
    cells = folder / "cells.toml"
    cells.write_text(SAMPLE)
    stability = ["stability", *CASE, "-o", str(folder / "stability" / "train.nc"), "--quiet"]
    run = str(folder / "evolve" / "run.nc")
    on = ["--until", "0.6", "--save-seconds", "0", "--quiet"]
    evolve = ["evolve", *CASE, "--disturbance", "random:3", "--every", "0.1", "-o", run, *on]
    sweep = ["sweep", str(study), "-o", str(folder / "sweep"), "--workers", "1", "--quiet"]
    sample = ["sweep", str(cells), "-o", str(folder / "sample"), "--workers", "1", "--quiet"]
    return [
        Job("stability", stability, stability, folder / "stability"),
        Job("evolve", evolve, ["evolve", "--resume", "-o", run, *on], folder / "evolve"),
        Job("sweep", sweep, sweep, folder / "sweep"),
        Job("sample", sample, sample, folder / "sample"),
    ]


def start(words: list[str]) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, "-c", PROGRAM, *words],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )


def same(one: dict[str, object], other: dict[str, object]) -> bool:
    return one.keys() == other.keys() and all(
        np.array_equal(one[name], other[name], equal_nan=np.asarray(one[name]).dtype.kind in "fc")  # type: ignore[arg-type]
        for name in one
    )


def main() -> None:
    parser = argparse.ArgumentParser(description="Kill commands and look at what is left.")
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    # A shell's background jobs ignore SIGINT, and so would what is started here.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    draw = random.Random(options.seed)
    counts: collections.Counter[str] = collections.Counter()
    slowest = 0.0
    with tempfile.TemporaryDirectory() as place:
        all_jobs = jobs(Path(place))
        for job in all_jobs:
            begin = time.monotonic()
            process = start(job.first)
            _, said = process.communicate()
            assert process.returncode == 0, said
            job.seconds = time.monotonic() - begin
            job.contents = job.read()
            job.clear()
            print(f"{job.name}: {job.seconds:.1f} s", flush=True)
        print(f"seed {options.seed}", flush=True)
        for number in range(options.kills):
            job = all_jobs[number % len(all_jobs)]
            killer = SIGNALS[number // len(all_jobs) % len(SIGNALS)]
            process = start(job.command())
            time.sleep(draw.uniform(0.0, job.seconds))
            begin = time.monotonic()
            process.send_signal(killer)
            _, said = process.communicate()
            took = time.monotonic() - begin
            outcome = _outcome(process.returncode, killer, said)
            slowest = max(slowest, took if outcome == "ended as asked" else 0.0)
            counts[outcome] += 1
            counts[f"{job.name}, {killer.name}"] += 1
            counts["later than two seconds"] += outcome == "ended as asked" and took > SOON
            opened = subprocess.run(
                [sys.executable, "-c", OPEN, str(job.folder)], capture_output=True, text=True
            )
            counts["unreadable files"] += opened.returncode != 0
            print(f"{number}: {job.name}, {killer.name}: {outcome}, {took:.2f} s", flush=True)
            if outcome not in ("ended as asked", "complete before"):
                print(f"status {process.returncode}: {said}", flush=True)
            if opened.returncode != 0:
                print(opened.stderr, flush=True)
            if process.returncode == 0:
                equal = same(job.read(), job.contents)
                counts[f"complete: {'equal' if equal else 'DIFFERENT'}"] += 1
                job.clear()
        for job in all_jobs:  # what is under way goes on to its end
            process = start(job.command())
            process.communicate()
            equal = process.returncode == 0 and same(job.read(), job.contents)
            counts[f"complete: {'equal' if equal else 'DIFFERENT'}"] += 1
    for what, count in sorted(counts.items()):
        print(f"{what}: {count}")
    print(f"slowest end: {slowest:.2f} s")


def _outcome(status: int, killer: signal.Signals, said: str) -> str:
    if status == 0:
        return "complete before"
    if killer == signal.SIGKILL:
        return "ended as asked" if status == -killer else "OTHER"
    if status == -killer and "celltrain" not in said.replace("celltrain.", ""):
        return "ended while Python itself began"
    lines = said.splitlines()
    once = len(lines) == 1 and lines[0].startswith("celltrain: interrupted; ")
    return "ended as asked" if status == 128 + killer and once else "OTHER"


if __name__ == "__main__":
    main()
