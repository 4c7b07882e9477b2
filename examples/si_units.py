"""A case in SI units: cells in a channel of 10 micrometres, as a designer would ask.

Physics. Blood of a given haematocrit flows at 1 mm/s through a capillary of 10 um, in single file.
How fast do the cells move, what pressure gradient is needed, and how far does the file travel
before a disturbance has grown tenfold?

Scaling. Everything is given and printed in SI; inside, lengths are in r0 = 2.8 um, velocities in
the mean velocity, viscosities in that of the plasma. `train.scales` holds the scales.

Reference. Moduli of the membrane: Bryngelson and Freund, Phys. Rev. Fluids 3, 073101 (2018), II.

Run time. Four seconds, the first time some more for compilation.

Command. ``python examples/si_units.py``
"""

import math

from celltrain import Stability, Train, stability
from celltrain.cli.progress import Reporter

DIAMETER = 10e-6  # m
MEAN_VELOCITY = 1e-3  # m/s
PLASMA_VISCOSITY = 1.2e-3  # Pa s
CELL_RADIUS = 2.8e-6  # m, of the sphere of a cell's volume
TUBE_HAEMATOCRIT = 0.12


def packing() -> float:
    """Packing fraction r0 N/L of the given haematocrit: cell volume over tube volume."""
    return TUBE_HAEMATOCRIT * 0.75 * (DIAMETER / 2 / CELL_RADIUS) ** 2


def describe(result: Stability) -> str:
    """The answers, in SI."""
    base = result.base
    train, scales = base.train, base.train.scales
    # Poiseuille: the gradient of the plasma alone at this flow rate is 8 mu U/R^2.
    plasma = 8.0 * scales.pressure / scales.radius / train.radius**2
    alpha = result.spectral_abscissa
    lines = [
        f"spacing of the cells      {train.period * scales.radius * 1e6:8.2f} um",
        f"velocity of the cells     {base.cell_velocity * scales.mean_velocity * 1e3:8.3f} mm/s",
        f"pressure gradient         {base.effective_viscosity * plasma / 1e6:8.3f} Pa/um",
        f"  of the plasma alone     {plasma / 1e6:8.3f} Pa/um",
        f"growth rate               {alpha / scales.time:8.3g} 1/s",
        f"  its error, estimated    {result.error_estimate / scales.time:8.3g} 1/s",
    ]
    if alpha > result.error_estimate:
        distance = base.cell_velocity * math.log(10.0) / alpha * scales.radius
        lines.append(f"tenfold growth after      {distance * 1e3:8.3f} mm of travel")
    return "\n".join(lines)


def main() -> None:
    train = Train.from_si(
        diameter=DIAMETER,
        mean_velocity=MEAN_VELOCITY,
        plasma_viscosity=PLASMA_VISCOSITY,
        radius=CELL_RADIUS,
        packing=packing(),
        cells=8,
    )
    with Reporter() as reporter:
        reporter.log(f"diameter {train.tube.diameter:.4g} r0, packing {train.packing:.3f}")
        result = stability(train, iteration=reporter.iteration, tell=reporter.log)
    print(describe(result))


if __name__ == "__main__":
    main()
