"""What near neighbours do to a train's growth."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar

from rich.console import Console

from celltrain.contract import Draw, OfStability, Progress, Setting
from celltrain.contract.tables import case_line, rate, titled
from celltrain.parameters import CaseError, Train
from celltrain.quantities import Record
from celltrain.stability import GrowthWithout, Stability, growth_without_neighbours
from celltrain.steady import Base


@dataclass(frozen=True, eq=False)
class GrowthWithoutNeighbours(Record):
    """Largest growth rates with the coupling of 0, 1, 2, ... near neighbours removed."""

    kind: ClassVar[str] = "neighbours"
    title: ClassVar[str] = "growth of a train without the coupling of near neighbours"

    base: Base
    entries: tuple[GrowthWithout, ...]


@dataclass(frozen=True, kw_only=True)
class WithoutNeighbours(OfStability[GrowthWithoutNeighbours]):
    """Compute the growth of a train with the coupling of near neighbours removed (Fig. 20)."""

    result = GrowthWithoutNeighbours

    removed: Annotated[
        int | None,
        Setting(
            "Largest number of neighbours to remove on each side; all if not given.", "0 to N/2"
        ),
    ] = None

    def check(self, train: Train) -> None:
        """Look at case and settings before anything is computed.

        Raises:
            CaseError: for what is not allowed.
        """
        super().check(train)
        if self.removed is not None and not 0 <= self.removed <= train.cells // 2:
            raise CaseError(
                f"removed = {self.removed} is not allowed; allowed: 0 to {train.cells // 2}"
            )

    def of(self, dynamics: Stability, progress: Progress) -> GrowthWithoutNeighbours:
        """The growth rate for each number of neighbours."""
        most = dynamics.base.train.cells // 2 if self.removed is None else self.removed
        entries = []
        for removed in range(most + 1):
            entries.append(growth_without_neighbours(dynamics, removed))
            progress.part("without near neighbours", removed + 1, most + 1)
        return GrowthWithoutNeighbours(dynamics.base, tuple(entries))

    @classmethod
    def report(cls, result: GrowthWithoutNeighbours, console: Console) -> None:
        """Print the growth rates as a table."""
        console.print(case_line(result.base))
        table = titled(
            "Largest growth rate without near neighbours (Eq. 22; q = 2 pi j/N)",
            *("removed on each side", "alpha, U/r0", "m", "j"),
            left=0,
        )
        for entry in result.entries:
            table.add_row(
                str(entry.removed),
                rate(entry.spectral_abscissa),
                str(entry.azimuthal_number),
                str(entry.wave_number),
            )
        console.print(table)

    @classmethod
    def pictures(cls, result: GrowthWithoutNeighbours) -> Mapping[str, Draw]:
        """The growth rate over the number of neighbours."""
        from celltrain.pictures import draw_growth_without_neighbours

        train = result.base.train
        name = rf"$D$ = {train.tube.diameter:g} $r_0$, $\phi$ = {train.packing:g}"
        return {"neighbours": lambda: draw_growth_without_neighbours({name: result.entries})}
