"""The command for trains without end: ``celltrain infinite``."""

from pathlib import Path
from typing import Annotated, Any

import numpy as np
from cyclopts import Parameter
from rich.console import Console
from rich.table import Table

from celltrain.cli.analyses import Analysis, analyse, save_dataset
from celltrain.cli.arguments import CaseFile, Json, Numbers, Plot, Quiet, Start
from celltrain.cli.compute import Request
from celltrain.cli.options import CaseOptions, given_leaves, reader
from celltrain.cli.progress import Reporter
from celltrain.parameters import Train
from celltrain.pictures import draw_dispersion
from celltrain.results import summary
from celltrain.stability import InfiniteTrain, check_linearisable, infinite_train
from celltrain.stability.infinite import NUMBERS, WaveMode, check_waves
from celltrain.steady import Base

Waves = Annotated[
    list[float] | None,
    Parameter(
        name="--wave-number",
        consume_multiple=True,
        negative=(),
        converter=reader(float, "allowed: 0, and numbers from 0.001 to pi"),
        help="Phases q from cell to cell to compute (radians, 0 or from 0.001 to pi); 17 in equal"
        " steps if not given.",
    ),
]
Output = Annotated[
    Path | None,
    Parameter(name=("--output", "-o"), help="netCDF file for the curves; replaced if it exists."),
]


def infinite(
    case: CaseFile = None,
    /,
    *,
    options: CaseOptions = None,
    wave_numbers: Waves = None,
    azimuthal_numbers: Numbers = None,
    start: Start = None,
    output: Output = None,
    plot: Plot = None,
    json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Compute the growth rates of waves of any length on an infinite train.

    Azimuthal numbers are 0 to 3 if none are given.
    """
    numbers = NUMBERS if azimuthal_numbers is None else tuple(azimuthal_numbers)
    waves = None if wave_numbers is None else np.unique(wave_numbers)

    def check(train: Train) -> None:
        check_linearisable(train, numbers)
        if waves is not None:
            check_waves(waves)

    def compute(base: Base, reporter: Reporter) -> InfiniteTrain:
        return infinite_train(
            base, wave_numbers=waves, azimuthal_numbers=numbers, progress=reporter.share
        )

    def pictures(result: InfiniteTrain, folder: Path) -> list[Path]:
        return [draw_dispersion(result, folder / "dispersion.png")]

    request = Request(case, start, output, plot, json, quiet)
    analysis = Analysis(check, compute, infinite_summary, print_infinite, pictures, _save)
    return analyse(request, given_leaves(options), analysis)


def _save(result: InfiniteTrain, path: Path) -> None:
    save_dataset(result.to_dataset(), path)


def infinite_summary(result: InfiniteTrain) -> dict[str, Any]:
    """Curves and most unstable wave as an object that JSON can hold; rates in U/r0."""
    numbers = result.azimuthal_numbers
    return {
        "base": summary(result.base),
        "norm": result.norm,
        "wave_numbers": result.wave_numbers.tolist(),
        "growth_rates": {str(m): result.growth_rates(m).tolist() for m in numbers},
        "frequencies": {str(m): result.frequencies(m).tolist() for m in numbers},
        "numerical_abscissas": {str(m): result.numerical_abscissas[m].tolist() for m in numbers},
        "most_unstable": _mode(result.most_unstable),
        "seconds": result.seconds,
    }


def _mode(mode: WaveMode) -> dict[str, Any]:
    return {
        "growth_rate": mode.growth_rate,
        "frequency": mode.frequency,
        "azimuthal_number": mode.azimuthal_number,
        "wave_number": mode.wave_number,
    }


def print_infinite(result: InfiniteTrain, console: Console) -> None:
    """Print the curves as a table, and the most unstable wave."""
    train, best = result.base.train, result.most_unstable
    console.print(
        f"infinite train: D = {train.tube.diameter:g} r0, packing {train.packing:g},"
        f" M = {train.resolution.degree}"
    )
    length = "all cells alike"
    if best.wave_number > 0.0:
        length = f"{2.0 * np.pi / best.wave_number:.4g} cells a wave"
    console.print(
        f"most unstable: growth rate {best.growth_rate:.5g} U/r0, frequency {best.frequency:.3g}"
        f" U/r0, m = {best.azimuthal_number}, q = {best.wave_number:.5g} ({length})"
    )
    table = Table(
        title="Largest growth rate for each m, U/r0", title_justify="left", title_style="bold"
    )
    table.add_column("q/pi", justify="right")
    for m in result.azimuthal_numbers:
        table.add_column(f"m = {m}", justify="right")
    for row, q in enumerate(result.wave_numbers):
        rates = [f"{result.growth_rates(m)[row]:.6f}" for m in result.azimuthal_numbers]
        table.add_row(f"{q / np.pi:.4f}", *rates)
    console.print(table)
