"""A branch of steady trains: the packing raised from 0.2 to 0.7, and where the train is stable.

Physics. At small packing the cells tilt, all alike; at large packing neighbours displace each
other. Between the two is a window in which the train keeps its order.

Scaling. Lengths in r0, velocities in U, rates in U/r0; tube of diameter 6, eight cells.

Reference. Bryngelson and Freund, Phys. Rev. Fluids 3, 073101 (2018), Figs. 5 and 6.

Run time. About ten seconds on two cores.

Command. ``python examples/continuation.py``; the table goes to standard output. Interrupted, it has
printed what it found.
"""

from celltrain import Base, Stability, Train, stability, steady
from celltrain.cli.progress import Reporter
from celltrain.continuation import BranchPoint, Steps, branch

HEAD = ("packing", "gap", "U_c", "alpha", "m", "j", "slope")


def dynamics(base: Base) -> Stability:
    """The modes that matter have few azimuths; errors are estimated in the demo."""
    return stability(base, azimuthal_numbers=range(4), estimate_error=False)


def show(point: BranchPoint) -> None:
    """One line for each train; the branch has a fold where the slope changes its sign."""
    leading = point.leading
    assert leading is not None
    row = (point.value, point.base.gap, point.base.cell_velocity, leading.growth_rate)
    formats = ("10.4f", "10.4f", "10.5f", "10.2e")
    numbers = "".join(f"{value:{form}}" for value, form in zip(row, formats, strict=True))
    place = f"{leading.azimuthal_number:10d}{leading.wave_number:10d}"
    print(f"{numbers}{place}{point.slope:10.3f}", flush=True)


def main() -> None:
    train = Train(diameter=6, packing=0.2, cells=8, degree=12)
    with Reporter() as reporter:
        start = steady(train, progress=reporter.iteration)
    print("".join(f"{name:>10}" for name in HEAD))
    steps = Steps(first=0.2, largest=0.4)
    found = branch(start, "packing", to=0.7, steps=steps, analyse=dynamics, progress=show)
    print(f"{len(found.points)} trains, folds after {found.folds}: {found.ending.message}")


if __name__ == "__main__":
    main()
