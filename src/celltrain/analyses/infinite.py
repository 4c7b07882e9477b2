"""Trains without end: waves of any length."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from rich.console import Console

from celltrain.contract import Draw, Progress, Setting
from celltrain.contract.analysis import OfDynamics
from celltrain.contract.tables import case_line, seconds_line, titled, verdict_line
from celltrain.parameters import Train
from celltrain.parameters.errors import called
from celltrain.results import Plain
from celltrain.stability import (
    NUMBERS,
    InfiniteTrain,
    infinite_train,
)
from celltrain.stability.infinite import check_phases
from celltrain.stability.verdict import infinite_verdict
from celltrain.steady import Base


@dataclass(frozen=True, kw_only=True)
class InfiniteStability(OfDynamics[InfiniteTrain]):
    """Compute the growth rates of waves of any length in an infinite train, and the fastest one.

    Azimuthal numbers are 0 to 3 if none are given.
    """

    result = InfiniteTrain

    phases: Annotated[
        Sequence[float] | None,
        Setting(
            "Phases q from cell to cell (radians, 0 or from 0.001 to pi); 17 in equal steps if not"
            " given.",
            "0, and numbers from 0.001 to pi",
            "phase",
        ),
    ] = None

    def check(self, train: Train) -> None:
        """Look at case and settings before anything is computed.

        Raises:
            CaseError: for what is not allowed.
        """
        super().check(train)
        if self.phases is not None:
            with called(phases="phase"):
                check_phases(np.unique(self.phases))

    def compute(self, train: Train, start: Base | None, progress: Progress) -> InfiniteTrain:
        """Compute the curves and the most unstable wave.

        Raises:
            NotConverged: if there is no steady train.
        """
        return infinite_train(
            train,
            start=start,
            phases=None if self.phases is None else np.unique(self.phases),
            azimuthal_numbers=self._numbers,
            accuracy=self.accuracy,
            progress=progress.share,
            iteration=progress.iteration,
            tell=progress.log,
        )

    @property
    def _numbers(self) -> tuple[int, ...]:
        return NUMBERS if self.azimuthal_numbers is None else tuple(self.azimuthal_numbers)

    @classmethod
    def summary(cls, result: InfiniteTrain) -> dict[str, Plain]:
        """Curves in place of modes."""
        content = super().summary(result)
        del content["leading"]
        numbers = result.azimuthal_numbers
        return {
            **content,
            "growth_rates": {str(m): result.growth_rates(m).tolist() for m in numbers},
            "frequencies": {str(m): result.frequencies(m).tolist() for m in numbers},
        }

    @classmethod
    def report(cls, result: InfiniteTrain, console: Console) -> None:
        """Print the most unstable wave, and the curves as a table."""
        best = result.most_unstable
        console.print(case_line(result.base, "infinite train"))
        console.print(verdict_line(infinite_verdict(result)))
        length = "all cells alike"
        if best.phase > 0.0:
            length = f"{2.0 * np.pi / best.phase:.4g} cells a wave"
        console.print(
            f"most unstable: growth rate {best.growth_rate:.5g} U/r0, frequency"
            f" {best.frequency:.3g} U/r0, m = {best.azimuthal_number}, q = {best.phase:.5g}"
            f" ({length})"
        )
        if not np.isnan(result.error_estimate):
            console.print(f"its error, estimated: {result.error_estimate:.2g} U/r0")
        numbers = result.azimuthal_numbers
        table = titled(
            "Largest growth rate for each m, U/r0", "q/pi", *(f"m = {m}" for m in numbers), left=0
        )
        for row, q in enumerate(result.phases):
            rates = [f"{result.growth_rates(m)[row]:.6f}" for m in numbers]
            table.add_row(f"{q / np.pi:.4f}", *rates)
        console.print(table)
        console.print(seconds_line(result.seconds))

    @classmethod
    def pictures(cls, result: InfiniteTrain) -> Mapping[str, Draw]:
        """The dispersion curves."""
        from celltrain.pictures import draw_dispersion

        return {"dispersion": lambda: draw_dispersion(result)}
