"""What destabilises a train: strain, spectra, turning, neighbours, and the flow between the cells.

Physics. The mode that grows in the end hardly strains the membrane: cells tilt and are displaced
almost as rigid bodies. The disturbance that grows fastest at first strains it a hundred times as
much, in fine waves, which is why it is gone soon. Without the coupling of nearest neighbours a
dense train is far less unstable. The flow in the cells' frame says how they are coupled.

Scaling. Lengths in r0, velocities in U, rates in U/r0, energies in mu U r0^2; tube of diameter 6,
eight cells, packings 0.2 and 0.7.

Reference. Bryngelson and Freund, Phys. Rev. Fluids 3, 073101 (2018): Eqs. (16) to (24), Table I,
Figs. 7, 10, 14 and 20. The validation page on mechanisms has the numbers beside the paper's.

Run time. About four minutes on two cores, the first time some more for compilation.

Command. ``python examples/mechanisms.py [FOLDER]``; pictures go to out/mechanisms unless told
otherwise.
"""

import sys
from pathlib import Path

from rich.console import Console

from celltrain import Base, Train, stability
from celltrain.cli.progress import Reporter
from celltrain.diagnostics import Mechanisms, mechanisms, meridional_flow, recirculation
from celltrain.pictures import (
    draw_deformation_spectra,
    draw_growth_without_neighbours,
    draw_mode_motions,
    draw_strain_energies,
    draw_streamlines,
)
from celltrain.stability import growth_without_neighbours

PACKINGS = (0.2, 0.7)


def main(folder: Path = Path("out/mechanisms")) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    output, curves = Console(), {}
    for packing in PACKINGS:
        train = Train(diameter=6, packing=packing, cells=8)
        with Reporter() as reporter:
            reporter.log(f"packing {packing:g}")
            result = stability(train, iteration=reporter.iteration, tell=reporter.log)
        name = f"packing {packing:g}"
        found = mechanisms(result)
        describe(found, name, output)
        curves[name] = [growth_without_neighbours(result, n) for n in range(5)]
        part = folder / f"phi-{packing:g}"
        part.mkdir(exist_ok=True)
        draw_strain_energies(found).savefig(part / "strain_energies.png")
        draw_deformation_spectra(found).savefig(part / "spectra.png")
        draw_mode_motions(found).savefig(part / "motions.png")
        streamlines(result.base, part, output)
    draw_growth_without_neighbours(curves).savefig(folder / "neighbours.png")
    output.print(str(folder / "neighbours.png"))


def describe(found: Mechanisms, name: str, output: Console) -> None:
    """Energies of both disturbances by part, and how the leading mode turns the cells."""
    for strain in found.strains:
        parts = ", ".join(f"{part} {value:.2e}" for part, value in strain.energies.items())
        output.print(
            f"{name}, {strain.name}: strain energy {strain.energy:.2e} mu U r0^2 ({parts})",
            highlight=False,
        )
    turning = found.modes[0]
    output.print(
        f"{name}, leading mode: tumbling {turning.tumbling:.3g}, tank-treading"
        f" {turning.tank_treading:.3g} U/r0^2",
        highlight=False,
    )


def streamlines(base: Base, folder: Path, output: Console) -> None:
    """The flow in the cells' frame."""
    flow = meridional_flow(base)
    found = recirculation(base, flow)
    output.print(
        f"velocity on the axis between cells {found.axis_velocity:+.1e} U,"
        f" {len(found.stagnation_points)} points of rest there",
        highlight=False,
    )
    draw_streamlines(base, flow).savefig(folder / "streamlines.png")


if __name__ == "__main__":
    main(*(Path(argument) for argument in sys.argv[1:2]))
