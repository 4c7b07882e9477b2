"""Trains without end on the command line: ``celltrain stability --infinite``."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from celltrain.cli.analyses import Analysis, analyse, save_dataset
from celltrain.cli.compute import Request
from celltrain.cli.progress import Reporter
from celltrain.parameters import Train
from celltrain.results import summary
from celltrain.stability import (
    NUMBERS,
    InfiniteTrain,
    check_accuracy,
    check_linearisable,
    infinite_train,
)
from celltrain.stability.infinite import WaveMode, check_phases
from celltrain.steady import Base


def run_infinite(
    request: Request,
    leaves: Mapping[str, Any],
    phases: Sequence[float] | None,
    azimuthal_numbers: Sequence[int] | None,
    accuracy: float,
) -> int:
    """Compute the growth rates of waves of any length; return the exit status.

    Raises:
        CaseError: for anything in the request that is not allowed, before computing.
    """
    numbers = NUMBERS if azimuthal_numbers is None else tuple(azimuthal_numbers)
    samples = None if phases is None else np.unique(phases)

    def check(train: Train) -> None:
        check_linearisable(train, numbers)
        check_accuracy(accuracy)
        if samples is not None:
            check_phases(samples)

    def compute(train: Train, start: Base | None, reporter: Reporter) -> InfiniteTrain:
        return infinite_train(
            train,
            start=start,
            phases=samples,
            azimuthal_numbers=numbers,
            accuracy=accuracy,
            progress=reporter.share,
            iteration=reporter.iteration,
            tell=reporter.log,
        )

    def pictures(result: InfiniteTrain, folder: Path) -> list[Path]:
        # Drawing takes half a second to load.
        from celltrain.pictures import draw_dispersion

        return [draw_dispersion(result, folder / "dispersion.png")]

    analysis = Analysis(check, compute, infinite_summary, print_infinite, pictures, _save)
    return analyse(request, leaves, analysis)


def _save(result: InfiniteTrain, path: Path) -> None:
    save_dataset(result.to_dataset(), path)


def infinite_summary(result: InfiniteTrain) -> dict[str, Any]:
    """Curves and most unstable wave as an object that JSON can hold; rates in U/r0."""
    numbers = result.azimuthal_numbers
    return {
        "base": summary(result.base),
        "norm": result.norm,
        "phases": result.phases.tolist(),
        "growth_rates": {str(m): result.growth_rates(m).tolist() for m in numbers},
        "frequencies": {str(m): result.frequencies(m).tolist() for m in numbers},
        "numerical_abscissas": {str(m): result.numerical_abscissas[m].tolist() for m in numbers},
        "most_unstable": _mode(result.most_unstable),
        "error_estimate": None if np.isnan(result.error_estimate) else result.error_estimate,
        "seconds": result.seconds,
    }


def _mode(mode: WaveMode) -> dict[str, Any]:
    return {
        "growth_rate": mode.growth_rate,
        "frequency": mode.frequency,
        "azimuthal_number": mode.azimuthal_number,
        "phase": mode.phase,
    }


def print_infinite(result: InfiniteTrain, console: Console) -> None:
    """Print the curves as a table, and the most unstable wave."""
    train, best = result.base.train, result.most_unstable
    console.print(
        f"infinite train: D = {train.tube.diameter:g} r0, packing {train.packing:g},"
        f" M = {train.degree}"
    )
    length = "all cells alike"
    if best.phase > 0.0:
        length = f"{2.0 * np.pi / best.phase:.4g} cells a wave"
    console.print(
        f"most unstable: growth rate {best.growth_rate:.5g} U/r0, frequency {best.frequency:.3g}"
        f" U/r0, m = {best.azimuthal_number}, q = {best.phase:.5g} ({length})"
    )
    if not np.isnan(result.error_estimate):
        console.print(f"its error, estimated: {result.error_estimate:.2g} U/r0")
    table = Table(
        title="Largest growth rate for each m, U/r0", title_justify="left", title_style="bold"
    )
    table.add_column("q/pi", justify="right")
    for m in result.azimuthal_numbers:
        table.add_column(f"m = {m}", justify="right")
    for row, q in enumerate(result.phases):
        rates = [f"{result.growth_rates(m)[row]:.6f}" for m in result.azimuthal_numbers]
        table.add_row(f"{q / np.pi:.4f}", *rates)
    console.print(table)
