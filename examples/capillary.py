"""A capillary of 5 micrometres at 1 mm/s, in SI units: how a cell squeezes through it.

Physics. In a tube narrower than itself a red blood cell is folded to a bullet with a dimple at its
rear, and a film of a few tenths of a micrometre of plasma lubricates it. How thick is the film, how
much faster than the blood is the cell, what pressure drop does each cell add, and does a file of
such cells keep its order?

Scaling. Everything is given and printed in SI; inside, lengths are in r0 = 2.8 um, velocities in
the mean velocity, viscosities in that of the plasma.

Reference. Pries, Neuhaus and Gaehtgens, Am. J. Physiol. 263, H1770 (1992), for the viscosity of
blood in tubes of glass; lubrication theory as in `celltrain.diagnostics.lubrication`.

Run time. A minute and a half: the degree rises to 64.

Command. ``python examples/capillary.py``
"""

from celltrain import Base, Stability, Train, stability
from celltrain.cli.progress import Reporter
from celltrain.diagnostics import discharge_haematocrit, in_vitro_viscosity, lubricated

DIAMETER = 5e-6  # m
MEAN_VELOCITY = 1e-3  # m/s
SPACING = 14e-6  # m, from cell to cell
CELL_RADIUS = 2.8e-6  # m, of the sphere of a cell's volume


def describe(base: Base) -> str:
    """The steady train, in SI."""
    train, scales = base.train, base.train.scales
    share = discharge_haematocrit(base)
    law = float(in_vitro_viscosity(DIAMETER * 1e6, share))
    _, lubrication = lubricated(base)
    # Poiseuille: the gradient of the plasma alone at this flow rate is 8 mu U/R^2.
    plasma = 8.0 * scales.pressure / scales.radius / train.radius**2
    length = (train.period - base.gap) * scales.radius
    speed = base.cell_velocity * scales.mean_velocity
    drop = (base.effective_viscosity - 1.0) * plasma * SPACING
    return "\n".join(
        (
            f"form of a cell               {base.form}",
            f"length                       {length * 1e6:8.2f} um",
            f"film                         {_film(base) * 1e6:8.3f} um",
            f"velocity of the cells        {speed * 1e3:8.3f} mm/s",
            f"discharge haematocrit        {share:8.3f}",
            f"pressure drop of each cell   {drop:8.2f} Pa",
            f"viscosity over plasma's      {base.effective_viscosity:8.3f}",
            f"  by lubrication theory      {lubrication:8.3f}",
            f"  of blood in tubes of glass {law:8.3f}",
        )
    )


def _film(base: Base) -> float:
    """The smallest distance from the wall, m."""
    return (base.train.radius - base.largest_radius) * base.train.scales.radius


def order(result: Stability) -> str:
    """Whether the file keeps its order, in SI."""
    rate = result.spectral_abscissa / result.base.train.scales.time
    mode = result.leading
    kind = {0: "spaces the cells unevenly", 1: "tilts the cells"}.get(
        mode.azimuthal_number, "changes their section"
    )
    if result.spectral_abscissa <= result.error_estimate:
        return "nothing grows: the file keeps its order"
    return f"a disturbance that {kind} grows e-fold in {1e3 / rate:.1f} ms"


def main() -> None:
    train = Train.from_si(
        diameter=DIAMETER,
        mean_velocity=MEAN_VELOCITY,
        radius=CELL_RADIUS,
        packing=CELL_RADIUS / SPACING,
        cells=8,
    )
    with Reporter() as reporter:
        result = stability(train, iteration=reporter.iteration, tell=reporter.log)
    print(describe(result.base))
    print(order(result))


if __name__ == "__main__":
    main()
