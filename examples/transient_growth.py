"""What a disturbance can do before the modes take over, and which measures of it can be trusted.

Physics. The dynamics of a train is not normal: disturbances that decay in the end may grow first.
Their largest growth rate at the first moment, eta, is a hundred times that of the unstable tilt,
but how far do they get? G(t) is the largest growth up to a time t. eta belongs to fine
disturbances, which grow fast for a short time, so it needs a high degree M of the discretisation:
at 12 it is a third too small. G(t) at any later time is known at once.

Scaling. Lengths in r0, velocities in U, times in r0/U; tube of diameter 6, packing 0.2, eight
cells.

Reference. Bryngelson and Freund, Phys. Rev. Fluids 3, 073101 (2018), Eqs. (13) to (15), Figs. 4, 8
and 9: transient disturbances there decay soon, too. Trefethen and Embree, Spectra and Pseudospectra
(2005), chapter 14.

Run time. A minute, the first time some more for compilation.

Command. ``python examples/transient_growth.py [FOLDER]``; the table goes to standard output, a
picture to out/transient_growth unless told otherwise. ``celltrain transient`` does one case.
"""

import sys
from pathlib import Path

import numpy as np

from celltrain import Train, stability
from celltrain.cli.progress import Reporter
from celltrain.pictures import draw_transient_growth
from celltrain.stability import NORMS, StrainNorm, transient_growth

DEGREES = (12, 24)
TIMES = (0.1, 0.5, 2.0, 10.0)
HEAD = ("M", "norm", "eta", *(f"G({time:g})" for time in TIMES), "peak", "at", "m", "j")


def main(folder: Path = Path("out/transient_growth")) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    print("".join(f"{name:>12}" for name in HEAD))
    for degree in DEGREES:
        train = Train(diameter=6, packing=0.2, cells=8, degree=degree)
        with Reporter() as reporter:
            reporter.log(f"degree {degree}")
            result = stability(
                train,
                azimuthal_numbers=range(4),
                estimate_error=False,
                iteration=reporter.iteration,
            )
        for norm in (*NORMS, StrainNorm(train)):
            growth = transient_growth(result, norm=norm)
            # The logarithm of G between the samples is nearly straight.
            values = np.exp(np.interp(TIMES, growth.times, np.log(growth.growth)))
            best = growth.optimal
            numbers = (growth.numerical_abscissa, *values, best.growth, best.time)
            print(
                f"{degree:12d}{norm.name:>12}"
                + "".join(f"{number:12.4f}" for number in numbers)
                + f"{best.azimuthal_number:12d}{best.wave_number:12d}",
                flush=True,
            )
            if degree == DEGREES[-1] and norm.name == "paper":
                draw_transient_growth(growth).savefig(folder / "transient_growth.png")
                print(folder / "transient_growth.png")


if __name__ == "__main__":
    main(*(Path(argument) for argument in sys.argv[1:2]))
