"""The numbers that the documentation quotes, computed anew.

    python validation/run.py [STUDY ... | all] [--reference FOLDER]
    python validation/run.py breakup --simulate NAME

Every study writes a page and a figure into docs/validation and states what is expected. Without
names all of them run, which takes half an hour on two cores with what is kept and hours without,
but for `breakup`, which takes hours and runs when it is named.
"""

import argparse
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

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

HERE = Path(__file__).resolve().parent
REFERENCE = HERE.parents[1] / "shared" / "reference"
# What only runs when it is named.
ON_REQUEST = ("breakup",)


def main() -> None:
    parser = argparse.ArgumentParser(description="Compute the pages of docs/validation anew.")
    parser.add_argument(
        "--reference",
        type=Path,
        default=REFERENCE,
        help="folder with the case of an independent code (default: ../shared/reference)",
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
        "figures": lambda options: figures.study(options.results),
        "disputed": lambda _: disputed.study(),
        "double_point": lambda _: double_point.study(),
        "initial_growth": lambda _: initial_growth.study(),
        "ad_hoc": lambda _: ad_hoc.study(),
        "norms": lambda _: norms.study(),
        "transients": lambda options: transients.study(options.march),
        "boundary": lambda _: boundary.study(),
        "capsules": lambda _: capsules.study(),
        "uncertainty": lambda _: uncertainty.study(),
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
    chosen = options.studies or [name for name in studies if name not in ON_REQUEST]
    if len(chosen) == 1:
        studies[chosen[0]](options)
        return
    # Each in a process of its own: compiled programs of one study would stay in memory.
    for name in chosen:
        command = [sys.executable, __file__, name, "--reference", str(options.reference)]
        if status := subprocess.run(command, check=False).returncode:
            sys.exit(f"{name} ended with status {status}")


if __name__ == "__main__":
    main()
