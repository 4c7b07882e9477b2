"""The command for further steady trains of a case: ``celltrain search``.

Exit status 0 whether or not there is another train: what was tried is the result.
"""

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter
from rich.console import Console
from rich.table import Table

from celltrain.cli.analyses import Analysis, analyse, save_dataset
from celltrain.cli.arguments import CaseFile, Json, Plot, Quiet, Start
from celltrain.cli.compute import Request
from celltrain.cli.options import CaseOptions, given_leaves, reader
from celltrain.cli.progress import Reporter
from celltrain.continuation import BranchSearch, SearchTry, search_trains
from celltrain.continuation.search import MOST_TRIES, check_tries
from celltrain.parameters import Train
from celltrain.results import save, summary
from celltrain.steady import Base, steady

MostTries = Annotated[
    int,
    Parameter(
        converter=reader(int, "allowed: whole numbers >= 1"),
        help="End after this many tries; each takes up to ten seconds at degree 12.",
    ),
]
Output = Annotated[
    Path | None,
    Parameter(
        name=("--output", "-o"),
        help="netCDF file for all trains; replaced if it exists. Every further one also gets a file"
        " of its own, NAME-1.nc, NAME-2.nc, ..., from which --start goes on.",
    ),
]


def search(
    case: CaseFile = None,
    /,
    *,
    options: CaseOptions = None,
    most_tries: MostTries = MOST_TRIES,
    start: Start = None,
    output: Output = None,
    plot: Plot = None,
    json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Search for further steady trains of a case, by deflation of those that are known.

    The known one is the train which the flow reaches from rest. That none is found proves nothing.
    """

    def check(_: Train) -> None:
        check_tries(most_tries)

    def compute(train: Train, start: Base | None, reporter: Reporter) -> BranchSearch:
        done: list[SearchTry] = []

        def show(each: SearchTry) -> None:
            done.append(each)
            reporter.log(f"try {len(done)}: from {each.guess}: {each.outcome}")
            reporter.part("search for further trains", len(done), most_tries)

        base = steady(train, start=start, progress=reporter.iteration)
        reporter.part("search for further trains", 0, most_tries)
        return search_trains(base, most_tries=most_tries, progress=show)

    def pictures(found: BranchSearch, folder: Path) -> list[Path]:
        # Drawing takes half a second to load.
        from celltrain.pictures.search import draw_search

        return [draw_search(found, folder / "search.png")]

    request = Request(case, start, output, plot, json, quiet)
    analysis = Analysis(check, compute, search_summary, print_search, pictures, _save)
    return analyse(request, given_leaves(options), analysis)


def _save(found: BranchSearch, path: Path) -> None:
    save_dataset(found.to_dataset(), path)
    for number, each in enumerate(found.found, 1):
        save(each.base, path.with_name(f"{path.stem}-{number}{path.suffix}"))


def search_summary(found: BranchSearch) -> dict[str, Any]:
    """Tries and trains as an object that JSON can hold, in r0, U and mu."""
    return {
        "known": summary(found.known),
        "statement": found.statement,
        "tries": [
            {
                "guess": each.guess,
                "steps": each.steps,
                "outcome": each.outcome,
                # Not a number if nothing could be evaluated.
                "residual": each.residual if each.residual == each.residual else None,
            }
            for each in found.tries
        ],
        "found": [
            {
                "guess": each.guess,
                "distance": each.distance,
                "axisymmetric_rate": each.axisymmetric_rate,
                **summary(each.base),
            }
            for each in found.found
        ],
    }


def print_search(found: BranchSearch, console: Console) -> None:
    """Print the tries, the trains if there are any, and the statement."""
    train = found.known.train
    console.print(
        f"D = {train.tube.diameter:g} r0, packing {train.packing:g}, M = {train.degree};"
        f" known: U_c = {found.known.cell_velocity:.5f} U ({found.known.origin})"
    )
    tries = _table("Tries", "from", "steps", "outcome")
    for each in found.tries:
        tries.add_row(each.guess, str(each.steps), each.outcome)
    console.print(tries)
    if found.found:
        trains = _table(
            "Further trains (r0, U, mu)", "from", "U_c", "gap", "mu_eff", "distance", "alpha, m = 0"
        )
        for other in found.found:
            numbers = (
                f"{other.base.cell_velocity:.5f}",
                f"{other.base.gap:.4f}",
                f"{other.base.effective_viscosity:.5f}",
                f"{other.distance:.3f}",
                f"{other.axisymmetric_rate:.5f}",
            )
            trains.add_row(other.guess, *numbers)
        console.print(trains)
    console.print(found.statement)


def _table(title: str, first: str, *columns: str) -> Table:
    table = Table(title=title, title_justify="left", title_style="bold")
    table.add_column(first)
    for column in columns:
        table.add_column(column, justify="left" if column == "outcome" else "right")
    return table
