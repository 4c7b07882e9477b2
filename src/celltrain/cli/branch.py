"""The command for branches of steady trains: ``celltrain branch``.

Exit status 0: the last value is reached, or the first one again behind a fold; 3: the branch could
not be followed as far; 130: interrupted. What was found is kept and shown in all cases.
"""

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter
from rich.console import Console
from rich.table import Table

from celltrain.cli.analyses import Analysis, analyse, save_dataset
from celltrain.cli.arguments import CaseFile, Json, Plot, Quiet, Start
from celltrain.cli.compute import NOT_CONVERGED, Request
from celltrain.cli.options import CaseOptions, given_leaves
from celltrain.cli.progress import Reporter
from celltrain.continuation import Branch, BranchPoint, check_branch
from celltrain.continuation import branch as follow
from celltrain.continuation.branch import ALONG
from celltrain.parameters import CaseError, Train
from celltrain.parameters.resolution import LEAST_DEGREE
from celltrain.parameters.routing import DIMENSIONS
from celltrain.results import summary
from celltrain.stability import NUMBERS, Stability, stability
from celltrain.steady import Base, steady

INTERRUPTED = 130

Along = Annotated[
    str, Parameter(help=f"Parameter that changes along the branch: {', '.join(ALONG)}.")
]
From = Annotated[
    float | None, Parameter(name="--from", help="Its first value; that of the case if not given.")
]
To = Annotated[float, Parameter(help="Its last value.")]
Stable = Annotated[
    bool,
    Parameter(
        name="--stability", negative=(), help="Compute the largest growth rate of every train."
    ),
]
Most = Annotated[int, Parameter(help="End after this many trains.")]
Output = Annotated[
    Path | None,
    Parameter(name=("--output", "-o"), help="netCDF file for the branch; replaced if it exists."),
]


def branch(
    case: CaseFile = None,
    /,
    *,
    along: Along,
    to: To,
    from_: From = None,
    options: CaseOptions = None,
    stable: Stable = False,
    most_points: Most = 100,
    start: Start = None,
    output: Output = None,
    plot: Plot = None,
    json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Follow the steady trains along a parameter, through folds.

    Growth rates are those of azimuthal numbers 0 to 3.
    """
    kinds: list[str] = []
    leaves = given_leaves(options)
    if from_ is not None:
        leaves |= {along: from_}

    def last(train: Train) -> float:
        """The last value as the package has it; options may be in SI."""
        if leaves.get("units") != "SI":
            return to
        return float(train.scales.dimensionless(DIMENSIONS[along], to))

    def check(train: Train) -> None:
        # The healthy reduced volume depends a little on a degree that may not be known yet; with
        # the one that it gets the branch checks again.
        check_branch(train.resolved(LEAST_DEGREE), along, last(train))
        if most_points < 1:
            raise CaseError(
                f"most_points = {most_points} is not allowed; allowed: whole numbers >= 1"
            )

    def dynamics(base: Base) -> Stability:
        return stability(base, azimuthal_numbers=NUMBERS, estimate_error=False)

    def compute(train: Train, start: Base | None, reporter: Reporter) -> Branch:
        def show(point: BranchPoint) -> None:
            reporter.log(f"{along} = {point.value:.6g}  {_numbers(point)}")

        base = steady(train, start=start, progress=reporter.iteration)
        found = follow(
            base,
            along,
            to=last(base.train),
            analyse=dynamics if stable else None,
            most_points=most_points,
            progress=show,
        )
        kinds.append(found.ending.kind)
        return found

    def pictures(found: Branch, folder: Path) -> list[Path]:
        # Drawing takes half a second to load.
        from celltrain.pictures.branch import draw_branch

        return [draw_branch(found, folder / "branch.png")]

    def save(found: Branch, path: Path) -> None:
        save_dataset(found.to_dataset(), path)

    request = Request(case, start, output, plot, json, quiet)
    status = analyse(
        request,
        leaves,
        Analysis(check, compute, branch_summary, print_branch, pictures, save),
    )
    if status:
        return status
    return {"lost": NOT_CONVERGED, "interrupted": INTERRUPTED}.get(kinds[0], 0)


def branch_summary(found: Branch) -> dict[str, Any]:
    """The branch as an object that JSON can hold, in r0, U and mu."""
    points = found.points
    rates = [None if point.stability is None else point.growth_rate for point in points]
    return {
        "start": summary(points[0].base),
        "parameter": found.parameter,
        "values": [point.value for point in points],
        "slopes": [point.slope for point in points],
        "cell_velocities": [point.base.cell_velocity for point in points],
        "gaps": [point.base.gap for point in points],
        "effective_viscosities": [point.base.effective_viscosity for point in points],
        "residuals": [point.base.residual for point in points],
        "growth_rates": rates,
        "folds": list(found.folds),
        "ending": {"kind": found.ending.kind, "message": found.ending.message},
    }


def print_branch(found: Branch, console: Console) -> None:
    """Print the trains of a branch as a table, and why there are no more."""
    table = Table(
        title=f"Branch along {found.parameter} (r0, U, mu)",
        title_justify="left",
        title_style="bold",
    )
    for column in (found.parameter, "U_c", "gap", "mu_eff", "residual", "alpha, U/r0", ""):
        table.add_column(column, justify="right")
    for number, point in enumerate(found.points):
        base = point.base
        table.add_row(
            f"{point.value:.6g}",
            f"{base.cell_velocity:.5f}",
            f"{base.gap:.4f}",
            f"{base.effective_viscosity:.5f}",
            f"{base.residual:.1e}",
            "" if point.stability is None else f"{point.growth_rate:.5f}",
            "fold" if number in found.folds else "",
        )
    console.print(table)
    console.print(found.ending.message)


def _numbers(point: BranchPoint) -> str:
    known = f"cell velocity {point.base.cell_velocity:.5f}"
    return known if point.stability is None else f"{known}  growth rate {point.growth_rate:.5f}"
