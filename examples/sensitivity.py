"""What makes the tilt of a loose train grow: derivatives by all parameters, and a check of one.

Physics. At packing 0.2 the cells tilt, all alike. Whether a wider tube, a denser train or a stiffer
membrane helps is told by the derivatives of the growth rate, the change of the steady train with
the parameter included: one computation instead of two more trains for each parameter.

Scaling. Lengths in r0, velocities in U, rates in U/r0, moduli in mu U; tube of diameter 6, eight
cells.

Reference. The train of Bryngelson and Freund, Phys. Rev. Fluids 3, 073101 (2018), Figs. 5 and 6;
the derivatives are not in the paper.

Run time. About ten seconds on two cores.

Command. ``python examples/sensitivity.py [FOLDER]``; the table goes to standard output, a picture
to out/sensitivity unless told otherwise. ``celltrain sensitivity`` does one case.
"""

import sys
from pathlib import Path

from celltrain import Base, Train, stability, steady
from celltrain.cli.progress import Reporter
from celltrain.pictures import draw_parameter_sensitivities
from celltrain.stability import parameter_sensitivities

HEAD = ("parameter", "value", "d alpha/dp", "p d alpha/dp", "dU_c/dp")
# Relative step of the difference quotient.
STEP = 2e-3


def growth_rate(base: Base) -> float:
    """Growth rate of the uniform tilt."""
    result = stability(base, azimuthal_numbers=[1], estimate_error=False)
    return next(mode.growth_rate for mode in result.modes if mode.wave_number == 0)


def main(folder: Path = Path("out/sensitivity")) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    train = Train(diameter=6, packing=0.2, cells=8, degree=12)
    with Reporter() as reporter:
        base = steady(train, progress=reporter.iteration)
        result = stability(base, azimuthal_numbers=[1], estimate_error=False)
        reporter.log("derivatives")
        found = parameter_sensitivities(result)
    draw_parameter_sensitivities(found).savefig(folder / "parameter_sensitivities.png")
    print("".join(f"{name:>20}" for name in HEAD))
    for name, entry in found.entries.items():
        numbers = (entry.growth_rate, entry.relative, entry.base.cell_velocity)
        print(f"{name:>20}{entry.value:20.5g}" + "".join(f"{each:20.5e}" for each in numbers))
    shear = train.cell.shear_modulus
    sides = (train.changed(shear_modulus=shear * (1.0 + step)) for step in (-STEP, STEP))
    below, above = (growth_rate(steady(side, start=base, estimate_error=False)) for side in sides)
    quotient = (above - below) / (2.0 * STEP * shear)
    exact = found.entries["shear_modulus"].growth_rate
    print(f"difference quotient by shear_modulus: {quotient:.6e}, exact {exact:.6e}")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
