"""Sensitivities of a growth rate: to parameters, and to places on the membrane."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar

from rich.console import Console

from celltrain.contract import Draw, OfStability, Progress, Setting
from celltrain.contract.tables import case_line, titled
from celltrain.parameters import CaseError, Train
from celltrain.quantities import Quantity, Record
from celltrain.stability import (
    ParameterSensitivities,
    Stability,
    StructuralSensitivity,
    condition_number,
    parameter_sensitivities,
    structural_sensitivity,
)
from celltrain.steady import Base
from celltrain.steady.parameters import PARAMETERS, check_parameters


@dataclass(frozen=True, eq=False)
class Sensitivity(Record):
    """What makes an eigenvalue: parameters of the train, and places on the membrane."""

    kind: ClassVar[str] = "sensitivity"
    title: ClassVar[str] = "sensitivities of a mode and its steady train"

    parameters: ParameterSensitivities
    structural: StructuralSensitivity
    condition_number: Annotated[
        float,
        Quantity(
            r"\kappa",
            "1",
            "condition number of the eigenvalue",
            equation=r"\kappa = |l| |r|/|\langle l, r\rangle|",
            source="Trefethen & Embree (2005), chapter 52",
        ),
    ]

    @property
    def base(self) -> Base:
        """The steady train."""
        return self.parameters.base


@dataclass(frozen=True, kw_only=True)
class ModeSensitivity(OfStability[Sensitivity]):
    """Compute how a growth rate changes with parameters, and where on the membrane it arises."""

    result = Sensitivity

    mode: Annotated[
        int,
        Setting(
            "Mode, from 1 by falling growth rate, neutral ones not counted.", "whole numbers >= 1"
        ),
    ] = 1
    parameters: Annotated[
        Sequence[str] | None,
        Setting(
            f"Parameters by which to differentiate: {', '.join(PARAMETERS)}; all if not given.",
            option="parameter",
        ),
    ] = None

    def check(self, train: Train) -> None:
        """Look at case and settings before anything is computed.

        Raises:
            CaseError: for what is not allowed.
        """
        super().check(train)
        if self.parameters is not None:
            check_parameters(self.parameters, train)
        if self.mode < 1:
            raise CaseError(f"mode = {self.mode} is not allowed; allowed: whole numbers >= 1")

    def of(self, dynamics: Stability, progress: Progress) -> Sensitivity:
        """All derivatives of the chosen mode.

        Raises:
            CaseError: if there are not as many modes.
        """
        modes = [each for each in dynamics.modes if not each.neutral]
        if self.mode > len(modes):
            raise CaseError(f"mode = {self.mode} is not allowed; allowed: 1 to {len(modes)}")
        chosen = modes[self.mode - 1]
        progress.log("derivatives by the parameters")
        return Sensitivity(
            parameter_sensitivities(dynamics, chosen, parameters=self.parameters),
            structural_sensitivity(dynamics, chosen),
            condition_number(dynamics, chosen),
        )

    @classmethod
    def report(cls, result: Sensitivity, console: Console) -> None:
        """Print the derivatives as tables."""
        found = result.parameters
        mode = found.mode
        console.print(case_line(found.base))
        console.print(
            f"mode m = {mode.azimuthal_number}, q = {mode.phase:.5g}: growth rate alpha ="
            f" {mode.growth_rate:.5g}, frequency omega = {mode.frequency:.3g} U/r0"
        )
        console.print(
            f"condition number of the eigenvalue {result.condition_number:.3g}; integral of the"
            f" structural sensitivity {result.structural.integral:.3g} (1 for a normal mode)"
        )
        words = "derivatives by p, in r0, U, mu"
        of_mode = titled(
            f"The mode (q held): {words}", "p", "value", "d alpha/dp", "d omega/dp", "p d alpha/dp"
        )
        of_base = titled(f"The steady train: {words}", "p", "dU_c/dp", "d mu_eff/dp")
        for entry in found.entries.values():
            rates = (entry.growth_rate, entry.frequency, entry.relative)
            of_mode.add_row(
                entry.parameter, f"{entry.value:.5g}", *(f"{each:.4g}" for each in rates)
            )
            numbers = (entry.base.cell_velocity, entry.base.effective_viscosity)
            of_base.add_row(entry.parameter, *(f"{each:.4g}" for each in numbers))
        console.print(of_mode)
        console.print(of_base)

    @classmethod
    def pictures(cls, result: Sensitivity) -> Mapping[str, Draw]:
        """Both kinds of sensitivity."""
        from celltrain.pictures import draw_parameter_sensitivities, draw_structural_sensitivity

        return {
            "parameter_sensitivities": lambda: draw_parameter_sensitivities(result.parameters),
            "structural_sensitivity": lambda: draw_structural_sensitivity(result.structural),
        }
