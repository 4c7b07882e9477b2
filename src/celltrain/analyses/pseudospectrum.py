"""Pseudospectra and the Kreiss constant of a block."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from rich.console import Console

from celltrain.analyses.transient import NormName, norm_named
from celltrain.contract import Draw, OfStability, Progress, Setting
from celltrain.contract.tables import case_line, quantities_table
from celltrain.parameters import CaseError, Train
from celltrain.stability import Pseudospectrum, Stability, check_linearisable, pseudospectrum


@dataclass(frozen=True, kw_only=True)
class BlockPseudospectrum(OfStability[Pseudospectrum]):
    """Compute the pseudospectra of a block of the dynamics, and its Kreiss constant.

    The block is that of the leading mode if none is given.
    """

    result = Pseudospectrum

    azimuthal_number: Annotated[int | None, Setting("Azimuthal number m of the block.")] = None
    wave_number: Annotated[
        int | None, Setting("Wave number j of the block, q = 2 pi j/N.", "0 to N/2")
    ] = None
    norm: NormName = "paper"
    points: Annotated[int, Setting("Points of the grid, each way.", "whole numbers >= 2")] = 101

    def check(self, train: Train) -> None:
        """Look at case and settings before anything is computed.

        Raises:
            CaseError: for what is not allowed.
        """
        super().check(train)
        if (self.azimuthal_number is None) != (self.wave_number is None):
            raise CaseError(
                "azimuthal_number and wave_number name a block together: give both or none"
            )
        if self.azimuthal_number is not None:
            check_linearisable(train, [self.azimuthal_number])
            known = self.azimuthal_numbers
            if known is not None and self.azimuthal_number not in known:
                raise CaseError(
                    f"azimuthal_number = {self.azimuthal_number} is not allowed; allowed: one of"
                    f" azimuthal_numbers ({', '.join(map(str, known))})"
                )
        if self.wave_number is not None and not 0 <= self.wave_number <= train.cells // 2:
            raise CaseError(
                f"wave_number = {self.wave_number} is not allowed; allowed: 0 to {train.cells // 2}"
            )
        if self.points < 2:
            raise CaseError(f"points = {self.points} is not allowed; allowed: whole numbers >= 2")

    def of(self, dynamics: Stability, progress: Progress) -> Pseudospectrum:
        """The pseudospectra of the block."""
        leading = dynamics.leading
        m = leading.azimuthal_number if self.azimuthal_number is None else self.azimuthal_number
        j = leading.wave_number if self.wave_number is None else self.wave_number
        progress.log(f"pseudospectrum of the block m = {m}, j = {j}")
        norm = norm_named(self.norm, dynamics.base.train)
        return pseudospectrum(dynamics, m, j, norm=norm, points=self.points)

    @classmethod
    def report(cls, result: Pseudospectrum, console: Console) -> None:
        """Print the constants of the block."""
        console.print(case_line(result.base))
        title = f"Block m = {result.azimuthal_number}, j = {result.wave_number}; norm {result.norm}"
        table = quantities_table(
            title, result, {"spectral_abscissa": ".5f", "numerical_abscissa": ".5f"}
        )
        point = result.kreiss.point
        table.add_row("Kreiss constant", f"{result.kreiss.constant:.4g}", "")
        table.add_row("  found at z", f"{point.real:.4g} {point.imag:+.4g} i", "U/r0")
        console.print(table)

    @classmethod
    def pictures(cls, result: Pseudospectrum) -> Mapping[str, Draw]:
        """The pseudospectra."""
        from celltrain.pictures import draw_pseudospectrum

        return {"pseudospectrum": lambda: draw_pseudospectrum(result)}
