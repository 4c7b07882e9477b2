"""The numbers that the documentation quotes, computed anew.

    python validation/run.py [STUDY ... | all] [--anew] [--reference FOLDER] [--work FOLDER]
    python validation/run.py breakup --simulate NAME

Every study writes a page and a figure into docs/validation and states what is expected. Without
names all of them run but for `breakup`, which takes hours and runs when it is named; `--anew`
computes also what is kept, but for simulations. As many run at once as there are processors, each
with one thread. What each took is printed as it ends; one that fails does not stop the others.
"""

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

# Before JAX, which it sets up.
import celltrain  # noqa: F401

# isort: split
import accuracy
import ad_hoc
import agreement
import boundary
import breakup
import capillaries
import capsules
import convergence
import disputed
import double_point
import figures
import haematocrit
import initial_growth
import map_degrees
import norms
import packing
import paper_page
import reference
import sphere
import transients
import uncertainty
from page import FOLDER

HERE = Path(__file__).resolve().parent
REFERENCE = HERE.parents[1] / "shared" / "reference"
# What only runs when it is named.
ON_REQUEST = ("breakup",)
# What begins first as it takes longest, and what reads what all others keep.
FIRST, LAST = ("figures", "map", "agreement", "uncertainty", "disputed"), ("paper",)
# Studies that run beside others have one thread each; NumPy and Numba ask these.
ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "NUMBA_NUM_THREADS": "1",
}
# Of docs/validation/data, what others found and what simulations left: kept by `--anew` as well.
NOT_COMPUTED = ("paper-solver.toml", "capsules-published.json", "capsules-others.json")
SIMULATED = ("transients.json", *(f"capsules-{each}.nc" for each in ("one", "two", "checks")))


def main() -> None:
    parser = argparse.ArgumentParser(description="Compute the pages of docs/validation anew.")
    parser.add_argument(
        "--reference",
        type=Path,
        default=REFERENCE,
        help="folder with the case of an independent code (default: ../shared/reference)",
    )
    parser.add_argument(
        "--work",
        type=Path,
        help="folder in which long studies keep each case, to go on when killed (default: out; with"
        " --anew a new folder in it)",
    )
    parser.add_argument(
        "--anew",
        action="store_true",
        help="with all: compute also what docs/validation/data keeps, but for simulations",
    )
    parser.add_argument(
        "--at-once",
        type=int,
        default=len(os.sched_getaffinity(0)),
        metavar="N",
        help="studies that run at the same time (default: one for each processor)",
    )
    studies: dict[str, Callable[[argparse.Namespace], object]] = {
        "sphere": lambda _: sphere.study(),
        "reference": lambda options: reference.study(options.reference),
        "convergence": lambda _: convergence.study(),
        "map": lambda options: map_degrees.study(options.workers),
        "packing": lambda _: packing.study(),
        "accuracy": lambda _: accuracy.study(),
        "agreement": lambda _: agreement.study(),
        "haematocrit": lambda _: haematocrit.study(),
        "capillaries": lambda _: capillaries.study(),
        "figures": lambda options: figures.study(options.work, options.results),
        "disputed": lambda _: disputed.study(),
        "double_point": lambda _: double_point.study(),
        "initial_growth": lambda _: initial_growth.study(),
        "ad_hoc": lambda _: ad_hoc.study(),
        "norms": lambda _: norms.study(),
        "transients": lambda options: transients.study(options.march),
        "boundary": lambda _: boundary.study(),
        "capsules": lambda _: capsules.study(),
        "uncertainty": lambda options: uncertainty.study(options.work),
        # From what the studies above keep.
        "paper": lambda _: paper_page.study(),
        "breakup": lambda options: breakup.study(
            options.runs, options.simulate, dict(options.take)
        ),
    }
    parser.add_argument("studies", nargs="*", metavar="STUDY", help=", ".join(studies))
    breakup.add_arguments(parser)
    figures.add_arguments(parser)
    map_degrees.add_arguments(parser)
    transients.add_arguments(parser)
    options = parser.parse_args()
    if options.studies == ["all"]:
        options.studies = []
    unknown = [name for name in options.studies if name not in studies]
    if unknown:
        parser.error(f"no such study: {', '.join(unknown)}; there are {', '.join(studies)}")
    if (options.simulate or options.take) and options.studies != ["breakup"]:
        parser.error("--simulate and --take are for the study breakup alone")
    if options.work is None:
        begun = f"anew-{datetime.now():%Y-%m-%d-%H%M%S}"
        options.work = Path("out", begun) if options.anew else Path("out")
    if options.at_once < 1:
        parser.error(f"--at-once = {options.at_once} is not allowed; allowed: a whole number >= 1")
    if options.anew and options.studies:
        parser.error("--anew is for all studies together: what one keeps, others read")
    chosen = options.studies or [name for name in studies if name not in ON_REQUEST]
    if len(chosen) == 1:
        studies[chosen[0]](options)
        return
    if options.anew:
        for path in (FOLDER / "data").iterdir():
            if path.name not in NOT_COMPUTED + SIMULATED:
                path.unlink()
    begin = time.perf_counter()
    order = sorted(chosen, key=lambda name: FIRST.index(name) if name in FIRST else len(FIRST))
    with ThreadPoolExecutor(options.at_once) as several:
        ended = list(
            several.map(
                lambda name: _run(name, options, ONE_THREAD if options.at_once > 1 else {}),
                [name for name in order if name not in LAST],
            )
        )
    ended += [_run(name, options, {}) for name in order if name in LAST]
    together = sum(each.processor_minutes for each in ended)
    minutes = (time.perf_counter() - begin) / 60.0
    print(f"{'together':16} {minutes:6.1f} minutes, {together:6.1f} of processors")
    sys.exit(any(each.status for each in ended))


class Ended(NamedTuple):
    """The exit status of a study that ran, and its minutes of processors."""

    status: int
    processor_minutes: float


def _run(name: str, options: argparse.Namespace, settings: dict[str, str]) -> Ended:
    """A study in a process of its own: compiled programs of one would stay in memory.

    What it took is printed at once: whoever stops the others knows it.
    """
    begin = time.perf_counter()
    process = subprocess.Popen(
        [
            *(sys.executable, __file__, name),
            *("--reference", str(options.reference), "--work", str(options.work)),
        ],
        env=os.environ | settings,
    )
    _, status, used = os.wait4(process.pid, 0)  # with what its own children took
    process.returncode = os.waitstatus_to_exitcode(status)
    minutes = (time.perf_counter() - begin) / 60.0
    processor_minutes = (used.ru_utime + used.ru_stime) / 60.0
    word = f"  ended with status {process.returncode}" if process.returncode else ""
    took = f"{minutes:6.1f} minutes, {processor_minutes:6.1f} of processors"
    print(f"{name:16} {took}{word}", flush=True)
    return Ended(process.returncode, processor_minutes)


if __name__ == "__main__":
    main()
