"""Branches of steady trains."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated

from rich.console import Console

from celltrain.continuation import Branch, BranchPoint, check_branch
from celltrain.continuation import branch as follow
from celltrain.continuation.branch import ALONG
from celltrain.contract import Analysis, Draw, Progress, Setting
from celltrain.contract.status import curve_status
from celltrain.contract.tables import case_line, titled
from celltrain.parameters import CaseError, Scales, Train
from celltrain.parameters.dimension import NUMBER
from celltrain.parameters.errors import called
from celltrain.parameters.resolution import LEAST_DEGREE
from celltrain.parameters.routing import DIMENSIONS
from celltrain.stability import NUMBERS, Stability, stability
from celltrain.steady import Base, steady


@dataclass(frozen=True, kw_only=True)
class SteadyBranch(Analysis[Branch]):
    """Follow the steady trains along a parameter, through folds.

    Growth rates are those of azimuthal numbers 0 to 3. Exit status 3: the branch could not be
    followed as far. What was found is kept and shown in all cases.
    """

    result = Branch

    along: Annotated[str, Setting(f"Parameter that changes along the branch: {', '.join(ALONG)}.")]
    to: Annotated[float, Setting("Its last value.", "numbers")]
    first: Annotated[
        float | None,
        Setting("Its first value; that of the case if not given.", "numbers", "from"),
    ] = None
    stability: Annotated[bool, Setting("Compute the largest growth rate of every train.")] = False
    most_points: Annotated[int, Setting("End after this many trains.", "whole numbers >= 1")] = 100

    def leaves(self) -> dict[str, float]:
        """The first value."""
        return {} if self.first is None else {self.along: self.first}

    def dimensionless(self, scales: Scales) -> "SteadyBranch":
        """With the last value in the package's units."""
        dimension = DIMENSIONS.get(self.along, NUMBER)
        return replace(self, to=scales.dimensionless(dimension, self.to))

    def check(self, train: Train) -> None:
        """Look at case and settings before anything is computed.

        Raises:
            CaseError: for what is not allowed.
        """
        # The healthy reduced volume depends a little on a degree that may not be known yet; with
        # the one that it gets the branch checks again.
        with called(parameter="along"):
            check_branch(train.resolved(LEAST_DEGREE), self.along, self.to)
        if self.most_points < 1:
            raise CaseError(
                f"most_points = {self.most_points} is not allowed; allowed: whole numbers >= 1"
            )

    def compute(self, train: Train, start: Base | None, progress: Progress) -> Branch:
        """Follow the branch.

        Raises:
            NotConverged: if there is no steady train at the first value.
        """

        def show(point: BranchPoint) -> None:
            progress.log(f"{self.along} = {point.value:.6g}  {_numbers(point)}")

        def dynamics(base: Base) -> Stability:
            return stability(base, azimuthal_numbers=NUMBERS, estimate_error=False)

        base = steady(train, start=start, progress=progress.iteration)
        return follow(
            base,
            self.along,
            to=self.to,
            analyse=dynamics if self.stability else None,
            most_points=self.most_points,
            progress=show,
        )

    @classmethod
    def report(cls, result: Branch, console: Console) -> None:
        """Print the trains of a branch as a table, and why there are no more."""
        console.print(case_line(result.points[0].base))
        table = titled(
            f"Branch along {result.parameter} (r0, U, mu)",
            *(result.parameter, "U_c", "gap", "mu_eff", "residual", "alpha, U/r0", "form", ""),
            left=0,
        )
        for number, point in enumerate(result.points):
            base = point.base
            table.add_row(
                f"{point.value:.6g}",
                f"{base.cell_velocity:.5f}",
                f"{base.gap:.4f}",
                f"{base.effective_viscosity:.5f}",
                f"{base.residual:.1e}",
                "" if point.leading is None else f"{point.growth_rate:.5f}",
                base.form,
                "fold" if number in result.folds else "",
            )
        console.print(table)
        console.print(result.ending.message)

    @classmethod
    def pictures(cls, result: Branch) -> Mapping[str, Draw]:
        """The trains over the parameter."""
        from celltrain.pictures import draw_branch

        return {"branch": lambda: draw_branch(result)}

    @classmethod
    def status(cls, result: Branch) -> int:
        """3 for a branch that was lost, 130 for one that was interrupted."""
        return curve_status(result.ending.kind)


def _numbers(point: BranchPoint) -> str:
    known = f"cell velocity {point.base.cell_velocity:.5f}"
    return known if point.leading is None else f"{known}  growth rate {point.growth_rate:.5f}"
