"""A branch of steady trains: the packing raised from 0.2 to 0.7, and where the train is stable.

Physics. At small packing the cells tilt, all alike; at large packing neighbours displace each
other. Between the two is a window in which the train keeps its order.

Scaling. Lengths in r0, velocities in U, rates in U/r0; tube of diameter 6, eight cells.

Reference. Bryngelson and Freund, Phys. Rev. Fluids 3, 073101 (2018), Figs. 5 and 6.

Run time. About six minutes on two cores (eleven trains).

Command. ``python examples/continuation.py``; the table goes to standard output.
"""

from rich.console import Console

from celltrain import Base, Train, stability, steady
from celltrain.cli.progress import Reporter

HEAD = ("packing", "gap", "U_c", "alpha", "m", "j")


def main() -> None:
    start: Base | None = None
    print("".join(f"{name:>10}" for name in HEAD))
    for step in range(11):
        train = Train(diameter=6, packing=round(0.2 + 0.05 * step, 2), cells=8)
        with Reporter(Console(stderr=True), quiet=False) as reporter:
            reporter.log(f"packing {train.packing:g}")
            start = steady(train, start=start, progress=reporter.iteration)
            # The modes that matter have few azimuths; errors are estimated in the demo.
            result = stability(
                start, azimuthal_numbers=range(4), estimate_error=False, progress=reporter.share
            )
        leading = result.leading
        row = (train.packing, start.gap, start.cell_velocity, result.spectral_abscissa)
        formats = ("10.2f", "10.4f", "10.5f", "10.2e")
        numbers = "".join(f"{value:{form}}" for value, form in zip(row, formats, strict=True))
        print(f"{numbers}{leading.azimuthal_number:10d}{leading.wave_number:10d}", flush=True)


if __name__ == "__main__":
    main()
