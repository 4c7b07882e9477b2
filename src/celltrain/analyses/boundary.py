"""The boundary of stability in the plane of diameter and packing."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from rich.console import Console

from celltrain.continuation import BoundaryPoint, StabilityBoundary, stability_boundary
from celltrain.continuation.boundary import crossing
from celltrain.contract import Analysis, Draw, Progress, Setting
from celltrain.contract.status import curve_status
from celltrain.contract.tables import case_line, titled
from celltrain.parameters import CaseError, Train
from celltrain.parameters.errors import called
from celltrain.stability import check_linearisable
from celltrain.stability.infinite import check_phases
from celltrain.steady import Base, steady


@dataclass(frozen=True, kw_only=True)
class Boundary(Analysis[StabilityBoundary]):
    """Follow the boundary of stability of a mode in the plane of diameter and packing.

    The mode is the fastest of its azimuthal number and phase where its growth rate changes sign
    with the packing, at the diameter that is given. Exit status 3: it could not be followed
    further.
    """

    result = StabilityBoundary

    azimuthal_number: Annotated[int, Setting("Azimuthal number m of the mode.")] = 1
    phase: Annotated[
        float,
        Setting(
            "Phase q of the mode from cell to cell (radians).", "0, and numbers from 0.001 to pi"
        ),
    ] = 0.0
    towards: Annotated[
        Literal["diameter", "packing"],
        Setting("Which of the two increases (or, with --falling, decreases) from the start."),
    ] = "diameter"
    falling: Annotated[bool, Setting("Follow it in the direction in which it decreases.")] = False
    most_points: Annotated[int, Setting("End after this many points.", "whole numbers >= 1")] = 20

    def check(self, train: Train) -> None:
        """Look at case and settings before anything is computed.

        Raises:
            CaseError: for what is not allowed.
        """
        with called(azimuthal_numbers="azimuthal_number", phases="phase"):
            check_linearisable(train, [self.azimuthal_number])
            check_phases(np.array([self.phase]))
        if self.most_points < 1:
            raise CaseError(
                f"most_points = {self.most_points} is not allowed; allowed: whole numbers >= 1"
            )

    def compute(self, train: Train, start: Base | None, progress: Progress) -> StabilityBoundary:
        """Compute the train that is given, and follow the boundary from there.

        Raises:
            NotConverged: if there is no steady train.
            CaseError: if there is no boundary near it.
        """

        def show(point: BoundaryPoint) -> None:
            progress.log(f"diameter {point.diameter:.6g}  packing {point.packing:.6g}")

        m, q = self.azimuthal_number, self.phase
        base = steady(train, start=start, progress=progress.iteration)
        progress.log(f"the boundary of m = {m}, q = {q:.4g} at this diameter")
        found = stability_boundary(
            crossing(base, azimuthal_number=m, phase=q),
            azimuthal_number=self.azimuthal_number,
            phase=self.phase,
            towards=self.towards,
            rising=not self.falling,
            most_points=self.most_points,
            progress=show,
        )
        if not found.points:
            raise CaseError(
                f"diameter = {train.tube.diameter:g}, packing = {train.packing:g} is not allowed:"
                f" no boundary can be followed from there ({found.ending.message}); allowed:"
                " another diameter, packing or mode"
            )
        return found

    @classmethod
    def report(cls, result: StabilityBoundary, console: Console) -> None:
        """Print the points as a table."""
        console.print(case_line(result.points[0].base))
        mode = result.points[0].mode
        table = titled(
            f"Boundary of stability, m = {mode.azimuthal_number}, q = {mode.phase:.5g}",
            *("diameter, r0", "packing", "alpha, U/r0", "frequency, U/r0", "U_c"),
            left=0,
        )
        for point in result.points:
            table.add_row(
                f"{point.diameter:.5f}",
                f"{point.packing:.5f}",
                f"{point.mode.growth_rate:.1e}",
                f"{point.mode.frequency:.5f}",
                f"{point.base.cell_velocity:.5f}",
            )
        console.print(table)
        console.print(result.ending.message)

    @classmethod
    def pictures(cls, result: StabilityBoundary) -> Mapping[str, Draw]:
        """The curve, with arrows into its unstable side."""
        from celltrain.pictures import draw_stability_boundary

        mode = result.points[0].mode
        name = f"$m$ = {mode.azimuthal_number}, $q$ = {mode.phase:.4g}"
        return {"boundary": lambda: draw_stability_boundary({name: result})}

    @classmethod
    def status(cls, result: StabilityBoundary) -> int:
        """3 for a curve that was lost, 130 for one that was interrupted."""
        return curve_status(result.ending.kind)
