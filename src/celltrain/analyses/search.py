"""Further steady trains of the same parameters."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from rich.console import Console

from celltrain.continuation import BranchSearch, SearchTry, search_trains
from celltrain.continuation.search import MOST_TRIES, check_tries
from celltrain.contract import Analysis, Draw, Progress, Setting
from celltrain.contract.tables import case_line, titled
from celltrain.parameters import Train
from celltrain.quantities import Record
from celltrain.steady import Base, steady


@dataclass(frozen=True, kw_only=True)
class SteadySearch(Analysis[BranchSearch]):
    """Search for further steady trains of a case: by the flow, and by deflation of those known.

    The known one is the train which the flow reaches from rest. The search is made at a low degree;
    what it finds is followed to a higher one, as low degrees have trains of their own, which are
    counted apart. That none is found proves nothing.
    With an output file every further train also gets one of its own, NAME-1.nc, NAME-2.nc, ...,
    from which --start goes on.
    """

    result = BranchSearch

    most_tries: Annotated[
        int,
        Setting(
            "End after this many tries; each takes at most some seconds at degree 12.",
            "whole numbers >= 1",
        ),
    ] = MOST_TRIES

    def check(self, train: Train) -> None:
        """Look at the settings before anything is computed.

        Raises:
            CaseError: for what is not allowed.
        """
        check_tries(self.most_tries)

    def compute(self, train: Train, start: Base | None, progress: Progress) -> BranchSearch:
        """Compute the known train, and search for others.

        Raises:
            NotConverged: if there is no steady train at all.
        """
        title = "search for further trains"
        done: list[SearchTry] = []

        def show(each: SearchTry) -> None:
            done.append(each)
            took = f"{each.way}, {each.steps} steps, {each.seconds:.1f} s"
            progress.log(f"try {len(done)}: from {each.guess}: {each.outcome} ({took})")
            progress.part(title, len(done), self.most_tries)

        base = steady(train, start=start, progress=progress.iteration)
        progress.part(title, 0, self.most_tries)
        return search_trains(base, most_tries=self.most_tries, progress=show)

    @classmethod
    def files(cls, result: BranchSearch, path: Path) -> Mapping[Path, Record]:
        """Every further train also has a file of its own, NAME-1.nc, NAME-2.nc, ..."""
        return {
            path: result,
            **{
                path.with_name(f"{path.stem}-{number}{path.suffix}"): each.base
                for number, each in enumerate(result.found, 1)
            },
        }

    @classmethod
    def report(cls, result: BranchSearch, console: Console) -> None:
        """Print the tries, the trains if there are any, and the statement."""
        known = result.known
        console.print(case_line(known))
        console.print(f"known: {known.form}, U_c = {known.cell_velocity:.5f} U ({known.origin})")
        tries = titled("Tries", "from", "by", "steps", "seconds", left=2)
        tries.add_column("outcome")
        for each in result.tries:
            row = (each.guess, each.way, str(each.steps), f"{each.seconds:.1f}", each.outcome)
            tries.add_row(*row)
        console.print(tries)
        if result.found:
            trains = titled(
                f"Further trains at degree {result.higher_degree} (r0, U, mu)",
                *("from", "form", "U_c", "gap", "mu_eff", "distance", "change", "alpha, m = 0"),
                left=2,
            )
            for other in result.found:
                trains.add_row(
                    other.guess,
                    other.base.form,
                    f"{other.base.cell_velocity:.5f}",
                    f"{other.base.gap:.4f}",
                    f"{other.base.effective_viscosity:.5f}",
                    f"{other.distance:.3f}",
                    f"{other.velocity_change:.0e}",
                    f"{other.axisymmetric_rate:.5f}",
                )
            console.print(trains)
        console.print(result.statement)

    @classmethod
    def pictures(cls, result: BranchSearch) -> Mapping[str, Draw]:
        """The meridians of all trains."""
        from celltrain.pictures import draw_search

        return {"search": lambda: draw_search(result)}
