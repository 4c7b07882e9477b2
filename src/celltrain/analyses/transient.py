"""Transient growth of disturbances."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from rich.console import Console

from celltrain.contract import Draw, OfStability, Progress, Setting
from celltrain.contract.tables import case_line, titled
from celltrain.parameters import CaseError, Train
from celltrain.results import Plain, plain
from celltrain.stability import (
    NORMS,
    BlockGrowth,
    Norm,
    Stability,
    StrainNorm,
    TransientGrowth,
    transient_growth,
)

NormName = Annotated[
    Literal["paper", "orthonormal", "surface", "strain"],
    Setting("Norm of disturbances, in which growth is measured."),
]


@dataclass(frozen=True, kw_only=True)
class TransientAnalysis(OfStability[TransientGrowth]):
    """Compute the transient growth of disturbances: how much, when, and of which.

    All azimuthal numbers are computed if none are given.
    """

    result = TransientGrowth

    norm: NormName = "paper"
    until: Annotated[float, Setting("Last time, r0/U.", "a number > 0")] = 10.0

    def check(self, train: Train) -> None:
        """Look at case and settings before anything is computed.

        Raises:
            CaseError: for what is not allowed.
        """
        super().check(train)
        if not (np.isfinite(self.until) and self.until > 0.0):
            raise CaseError(f"until = {self.until:g} is not allowed; allowed: a number > 0")

    def of(self, dynamics: Stability, progress: Progress) -> TransientGrowth:
        """How far disturbances grow."""
        norm = norm_named(self.norm, dynamics.base.train)
        return transient_growth(dynamics, norm=norm, until=self.until)

    @classmethod
    def summary(cls, result: TransientGrowth) -> dict[str, Plain]:
        """With the steady train in place of all its dynamics."""
        content = super().summary(result)
        return {**content, "base": plain(result.base)}

    @classmethod
    def report(cls, result: TransientGrowth, console: Console) -> None:
        """Print the transient growth, for each azimuthal number the wave that peaks highest."""
        base, optimal = result.base, result.optimal
        console.print(case_line(base))
        console.print(
            f"norm: {result.norm}; initial growth rate (eta) {result.numerical_abscissa:.5g} U/r0,"
            f" growth rate for long times (alpha) {result.spectral_abscissa:.5g} U/r0"
        )
        console.print(
            f"of disturbances that peak, the largest growth is by a factor of {optimal.growth:.4g},"
            f" after {optimal.time:.4g} r0/U (m = {optimal.azimuthal_number}, q = 2 pi"
            f" {optimal.wave_number}/{base.train.cells})"
            if any(block.peak.interior and block.peak.time > 0.0 for block in result.blocks)
            else f"nothing grows and falls again within {result.times[-1]:g} r0/U"
        )
        last = f"at {result.times[-1]:g}"
        table = titled(
            "The highest peak for each m (q = 2 pi j/N)",
            *("m", "j", "eta, U/r0", "alpha, U/r0", "peak", "at, r0/U", last),
            left=0,
        )
        for m in result.result.azimuthal_numbers:
            best = max(
                (block for block in result.blocks if block.azimuthal_number == m),
                key=lambda block: (block.peak.interior, block.peak.growth),
            )
            table.add_row(*_row(best))
        table.caption = "+: no peak, growing to the last time"
        console.print(table)

    @classmethod
    def pictures(cls, result: TransientGrowth) -> Mapping[str, Draw]:
        """G(t), and the optimal disturbance."""
        from celltrain.pictures import draw_transient_growth

        return {"transient_growth": lambda: draw_transient_growth(result)}


def norm_named(name: str, train: Train) -> Norm:
    """The norm of a name."""
    if name == "strain":
        return StrainNorm(train)
    return next(norm for norm in NORMS if norm.name == name)


def _row(block: BlockGrowth) -> tuple[str, ...]:
    return (
        str(block.azimuthal_number),
        str(block.wave_number),
        f"{block.numerical_abscissa:.4f}",
        f"{block.spectral_abscissa:.5f}",
        f"{block.peak.growth:.4f}",
        f"{block.peak.time:.3f}" + ("" if block.peak.interior else "+"),
        f"{block.growth[-1]:.4f}",
    )
