"""What disturbances do to the cells."""

from collections.abc import Mapping
from dataclasses import dataclass

from rich.console import Console

from celltrain.contract import Draw, OfStability, Progress
from celltrain.contract.tables import case_line, rate, titled
from celltrain.diagnostics import Mechanisms, mechanisms
from celltrain.extras import check_installed
from celltrain.parameters import Train
from celltrain.stability import Stability


@dataclass(frozen=True, kw_only=True)
class DisturbanceMechanisms(OfStability[Mechanisms]):
    """Compute how the leading modes turn, strain and deform the cells (Eqs. 16 to 24)."""

    result = Mechanisms

    def check(self, train: Train) -> None:
        """Look at case and settings before anything is computed.

        Raises:
            CaseError: for what is not allowed.
            MissingExtra: without the extra `simulations`.
        """
        check_installed("simulations")
        super().check(train)

    def of(self, dynamics: Stability, progress: Progress) -> Mechanisms:
        """Turning, strain and deformation."""
        progress.log("turning, strain and deformation of disturbances")
        return mechanisms(dynamics)

    @classmethod
    def report(cls, result: Mechanisms, console: Console) -> None:
        """Print turning and strain as tables."""
        console.print(case_line(result.base))
        turning = titled(
            "Turning, for each unit of the amplitude (q = 2 pi j/N)",
            *("m", "j", "growth rate, U/r0", "tumbling, U/r0^2", "tank-treading, U/r0^2"),
            left=0,
        )
        for mode in result.modes:
            turning.add_row(
                str(mode.azimuthal_number),
                str(mode.wave_number),
                rate(mode.growth_rate),
                f"{mode.tumbling:.4g}",
                f"{mode.tank_treading:.4g}",
            )
        console.print(turning)
        strain = titled(
            "Strain energy at the paper's amplitude, mu U r0^2 (Eq. 24)",
            *("disturbance", "m", "j", *result.strains[0].energies, "sum"),
        )
        for each in result.strains:
            parts = [*each.energies.values(), each.energy]
            strain.add_row(
                each.name,
                str(each.azimuthal_number),
                str(each.wave_number),
                *(f"{value:.3e}" for value in parts),
            )
        console.print(strain)

    @classmethod
    def pictures(cls, result: Mechanisms) -> Mapping[str, Draw]:
        """Energies, spectra and motions."""
        from celltrain.pictures import (
            draw_deformation_spectra,
            draw_mode_motions,
            draw_strain_energies,
        )

        return {
            "energies": lambda: draw_strain_energies(result),
            "spectra": lambda: draw_deformation_spectra(result),
            "motions": lambda: draw_mode_motions(result),
        }
