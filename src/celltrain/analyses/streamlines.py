"""The flow around the cells of a steady train."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from rich.console import Console

from celltrain.contract import Analysis, Draw, Progress
from celltrain.contract.tables import case_line, quantities_table
from celltrain.diagnostics import MeridionalFlow, Recirculation, meridional_flow, recirculation
from celltrain.extras import check_installed
from celltrain.parameters import Train
from celltrain.quantities import Record
from celltrain.steady import Base, steady


@dataclass(frozen=True, eq=False)
class FlowInCellFrame(Record):
    """The flow in the cells' frame, and what turns back between them."""

    kind: ClassVar[str] = "streamlines"
    title: ClassVar[str] = "flow around the cells of a steady train, in their frame"

    base: Base
    flow: MeridionalFlow
    recirculation: Recirculation


@dataclass(frozen=True, kw_only=True)
class FlowAroundCells(Analysis[FlowInCellFrame]):
    """Compute the flow around the cells, and what turns back between them (Fig. 7)."""

    result = FlowInCellFrame

    def check(self, train: Train) -> None:
        """Look at case and settings before anything is computed.

        Raises:
            MissingExtra: without the extra `simulations`.
        """
        check_installed("simulations")

    def compute(self, train: Train, start: Base | None, progress: Progress) -> FlowInCellFrame:
        """Compute the steady train and the flow.

        Raises:
            NotConverged: if there is no steady train.
        """
        base = steady(train, start=start, progress=progress.iteration)
        progress.log("velocity of the fluid between the cells")
        flow = meridional_flow(base)
        return FlowInCellFrame(base, flow, recirculation(base, flow))

    @classmethod
    def report(cls, result: FlowInCellFrame, console: Console) -> None:
        """Print what turns back."""
        found = result.recirculation
        console.print(case_line(result.base))
        table = quantities_table(
            "Between two cells", found, {"axis_velocity": ".4g", "strength": ".3g"}
        )
        points = ", ".join(f"{place:.4f}" for place in found.stagnation_points) or "none"
        table.add_row("points of rest on the axis", points, "r0")
        console.print(table)

    @classmethod
    def pictures(cls, result: FlowInCellFrame) -> Mapping[str, Draw]:
        """The streamlines."""
        from celltrain.pictures import draw_streamlines

        return {"streamlines": lambda: draw_streamlines(result.base, result.flow)}
