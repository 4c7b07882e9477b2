"""The command for transient growth: ``celltrain transient``."""

from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from cyclopts import Parameter
from rich.console import Console
from rich.table import Table

from celltrain.cli.analyses import Analysis, analyse
from celltrain.cli.arguments import Accuracy, CaseFile, Json, Numbers, Plot, Quiet, Start
from celltrain.cli.compute import Request
from celltrain.cli.options import CaseOptions, given_leaves
from celltrain.cli.progress import Reporter
from celltrain.parameters import CaseError, Train
from celltrain.results import summary
from celltrain.stability import (
    ACCURACY,
    NORMS,
    BlockGrowth,
    Norm,
    StrainNorm,
    TransientGrowth,
    check_accuracy,
    check_linearisable,
    stability,
    transient_growth,
)
from celltrain.steady import Base

NormName = Annotated[
    Literal["paper", "orthonormal", "surface", "strain"],
    Parameter(help="Norm of disturbances, in which growth is measured."),
]
Until = Annotated[float, Parameter(help="Last time, r0/U.")]


def transient(
    case: CaseFile = None,
    /,
    *,
    options: CaseOptions = None,
    norm: NormName = "paper",
    until: Until = 10.0,
    azimuthal_numbers: Numbers = None,
    accuracy: Accuracy = ACCURACY,
    start: Start = None,
    plot: Plot = None,
    json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Compute the transient growth of disturbances: how much, when, and of which.

    All azimuthal numbers are computed if none are given.
    """

    def check(train: Train) -> None:
        check_linearisable(train, azimuthal_numbers)
        check_accuracy(accuracy)
        if not (np.isfinite(until) and until > 0.0):
            raise CaseError(f"until = {until:g} is not allowed; allowed: a number > 0")

    def compute(train: Train, start: Base | None, reporter: Reporter) -> TransientGrowth:
        result = stability(
            train,
            start=start,
            accuracy=accuracy,
            azimuthal_numbers=azimuthal_numbers,
            estimate_error=False,
            progress=reporter.share,
            iteration=reporter.iteration,
            tell=reporter.log,
        )
        return transient_growth(result, norm=_norm(norm, result.base.train), until=until)

    def pictures(growth: TransientGrowth, folder: Path) -> list[Path]:
        # Drawing takes half a second to load.
        from celltrain.pictures import draw_transient_growth

        return [draw_transient_growth(growth, folder / "transient_growth.png")]

    request = Request(case=case, start=start, plot=plot, json=json, quiet=quiet)
    analysis = Analysis(check, compute, transient_summary, print_transient, pictures)
    return analyse(request, given_leaves(options), analysis)


def _norm(name: str, train: Train) -> Norm:
    if name == "strain":
        return StrainNorm(train)
    return next(norm for norm in NORMS if norm.name == name)


def transient_summary(growth: TransientGrowth) -> dict[str, Any]:
    """Transient growth as an object that JSON can hold; rates in U/r0, times in r0/U."""
    optimal = growth.optimal
    return {
        "base": summary(growth.result.base),
        "norm": growth.norm,
        "numerical_abscissa": growth.numerical_abscissa,
        "spectral_abscissa": growth.spectral_abscissa,
        "times": growth.times.tolist(),
        "growth": growth.growth.tolist(),
        "growth_of_leading_mode": growth.modal.tolist(),
        "growth_of_fastest_at_first": growth.abrupt.tolist(),
        "optimal": {
            "azimuthal_number": optimal.azimuthal_number,
            "wave_number": optimal.wave_number,
            "time": optimal.time,
            "growth": optimal.growth,
        },
        "blocks": [
            {
                "azimuthal_number": block.azimuthal_number,
                "wave_number": block.wave_number,
                "numerical_abscissa": block.numerical_abscissa,
                "spectral_abscissa": block.spectral_abscissa,
                "peak_time": block.peak.time,
                "peak_growth": block.peak.growth,
                "peak_interior": block.peak.interior,
                "growth": block.growth.tolist(),
            }
            for block in growth.blocks
        ],
    }


def print_transient(growth: TransientGrowth, console: Console) -> None:
    """Print the transient growth, for each azimuthal number the wave that peaks highest."""
    base, optimal = growth.result.base, growth.optimal
    console.print(
        f"D = {base.train.tube.diameter:g} r0, packing {base.train.packing:g}, N ="
        f" {base.train.cells}, M = {base.train.degree}; norm: {growth.norm}"
    )
    console.print(
        f"initial growth rate (eta) {growth.numerical_abscissa:.5g} U/r0, growth rate for long"
        f" times (alpha) {growth.spectral_abscissa:.5g} U/r0"
    )
    console.print(
        f"the largest passing growth is {optimal.growth:.4g} times, after {optimal.time:.4g} r0/U"
        f" (m = {optimal.azimuthal_number}, q = 2 pi {optimal.wave_number}/{base.train.cells})"
        if any(block.peak.interior and block.peak.time > 0.0 for block in growth.blocks)
        else f"nothing grows and falls again within {growth.times[-1]:g} r0/U"
    )
    table = Table(
        title="The highest peak for each m (q = 2 pi j/N)",
        title_justify="left",
        title_style="bold",
    )
    last = f"at {growth.times[-1]:g}"
    for column in ("m", "j", "eta, U/r0", "alpha, U/r0", "peak", "at, r0/U", last):
        table.add_column(column, justify="right")
    for m in growth.result.azimuthal_numbers:
        best = max(
            (block for block in growth.blocks if block.azimuthal_number == m),
            key=lambda block: (block.peak.interior, block.peak.growth),
        )
        table.add_row(*_row(best))
    table.caption = "+: no peak, growing to the last time"
    table.caption_justify = "left"
    console.print(table)


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
