"""The command for sensitivities: ``celltrain sensitivity``."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter
from rich.console import Console
from rich.table import Table

from celltrain.cli.analyses import Analysis, analyse, save_dataset
from celltrain.cli.arguments import Accuracy, Json, Plot, Quiet
from celltrain.cli.compute import Request
from celltrain.cli.options import CaseOptions, given_leaves
from celltrain.cli.progress import Reporter
from celltrain.parameters import CaseError, Train
from celltrain.results import summary
from celltrain.stability import (
    ACCURACY,
    ParameterSensitivities,
    StructuralSensitivity,
    check_accuracy,
    condition_number,
    parameter_sensitivities,
    stability,
    structural_sensitivity,
)
from celltrain.steady import Base
from celltrain.steady.parameters import PARAMETERS, check_parameters

Source = Annotated[
    Path | None,
    Parameter(
        help="TOML file of the case, or netCDF file of a result (.nc), whose train is taken;"
        " options override the case."
    ),
]
Number = Annotated[
    int, Parameter(help="Mode, from 1 by falling growth rate, neutral ones not counted.")
]
Names = Annotated[
    list[str] | None,
    Parameter(
        name="--parameter",
        consume_multiple=True,
        negative=(),
        help=f"Parameters by which to differentiate: {', '.join(PARAMETERS)}; all if not given.",
    ),
]
Output = Annotated[
    Path | None,
    Parameter(name=("--output", "-o"), help="netCDF file for both; replaced if it exists."),
]


@dataclass(frozen=True)
class Sensitivity:
    """What makes an eigenvalue: parameters of the train, and places on the membrane."""

    parameters: ParameterSensitivities
    structural: StructuralSensitivity
    condition_number: float


def sensitivity(
    source: Source = None,
    /,
    *,
    options: CaseOptions = None,
    mode: Number = 1,
    parameters: Names = None,
    accuracy: Accuracy = ACCURACY,
    output: Output = None,
    plot: Plot = None,
    json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Compute how a growth rate changes with the train's parameters, and where it is made."""

    def check(train: Train) -> None:
        check_accuracy(accuracy)
        if parameters is not None:
            check_parameters(parameters, train)
        if mode < 1:
            raise CaseError(f"mode = {mode} is not allowed; allowed: whole numbers >= 1")

    def compute(train: Train, start: Base | None, reporter: Reporter) -> Sensitivity:
        result = stability(
            train,
            start=start,
            accuracy=accuracy,
            estimate_error=False,
            progress=reporter.share,
            iteration=reporter.iteration,
            tell=reporter.log,
        )
        modes = [each for each in result.modes if not each.neutral]
        if mode > len(modes):
            raise CaseError(f"mode = {mode} is not allowed; allowed: 1 to {len(modes)}")
        chosen = modes[mode - 1]
        reporter.log("derivatives by the parameters")
        return Sensitivity(
            parameter_sensitivities(result, chosen, parameters=parameters),
            structural_sensitivity(result, chosen),
            condition_number(result, chosen),
        )

    def pictures(result: Sensitivity, folder: Path) -> list[Path]:
        # Drawing takes half a second to load.
        from celltrain.pictures import draw_parameter_sensitivities, draw_structural_sensitivity

        return [
            draw_parameter_sensitivities(result.parameters, folder / "parameter_sensitivities.png"),
            draw_structural_sensitivity(result.structural, folder / "structural_sensitivity.png"),
        ]

    def save(result: Sensitivity, path: Path) -> None:
        both = result.parameters.to_dataset().merge(result.structural.to_dataset())
        save_dataset(both.assign_attrs(result.parameters.to_dataset().attrs), path)

    known = source if source is not None and source.suffix == ".nc" else None
    request = Request(None if known else source, known, output, plot, json, quiet)
    analysis = Analysis(check, compute, sensitivity_summary, print_sensitivity, pictures, save)
    return analyse(request, given_leaves(options), analysis)


def sensitivity_summary(result: Sensitivity) -> dict[str, Any]:
    """All derivatives as an object that JSON can hold, in r0, U and mu."""
    found = result.parameters
    mode = found.mode
    return {
        "base": summary(found.base),
        "mode": {
            "growth_rate": mode.growth_rate,
            "frequency": mode.frequency,
            "azimuthal_number": mode.azimuthal_number,
            "phase": mode.phase,
        },
        "condition_number": result.condition_number,
        "structural_sensitivity": result.structural.integral,
        "parameters": {
            name: {
                "value": entry.value,
                "growth_rate": entry.growth_rate,
                "frequency": entry.frequency,
                "cell_velocity": entry.base.cell_velocity,
                "effective_viscosity": entry.base.effective_viscosity,
            }
            for name, entry in found.entries.items()
        },
    }


def print_sensitivity(result: Sensitivity, console: Console) -> None:
    """Print the derivatives as a table."""
    found, train = result.parameters, result.parameters.base.train
    mode = found.mode
    console.print(
        f"D = {train.tube.diameter:g} r0, packing {train.packing:g}, N = {train.cells},"
        f" M = {train.degree}"
    )
    console.print(
        f"mode m = {mode.azimuthal_number}, q = {mode.phase:.5g}: growth rate alpha ="
        f" {mode.growth_rate:.5g}, frequency omega = {mode.frequency:.3g} U/r0"
    )
    console.print(
        f"condition number of the eigenvalue {result.condition_number:.3g}; integral of the"
        f" structural sensitivity {result.structural.integral:.3g} (1 for a normal mode)"
    )
    entries = found.entries.values()
    of_mode = _table("The mode (q held)", "p", "value", "d alpha/dp", "d omega/dp", "p d alpha/dp")
    of_base = _table("The steady train", "p", "dU_c/dp", "d mu_eff/dp")
    for entry in entries:
        rates = (entry.growth_rate, entry.frequency, entry.relative)
        of_mode.add_row(entry.parameter, f"{entry.value:.5g}", *(f"{each:.4g}" for each in rates))
        numbers = (entry.base.cell_velocity, entry.base.effective_viscosity)
        of_base.add_row(entry.parameter, *(f"{each:.4g}" for each in numbers))
    console.print(of_mode)
    console.print(of_base)


def _table(title: str, *columns: str) -> Table:
    table = Table(
        title=f"{title}: derivatives by p, in r0, U, mu", title_justify="left", title_style="bold"
    )
    for number, column in enumerate(columns):
        table.add_column(column, justify="right" if number else "left")
    return table
