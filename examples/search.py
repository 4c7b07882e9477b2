"""Is the bullet the only steady train? A search from some twenty shapes.

Physics. The train that the flow reaches from rest need not be the only one: cells could point the
other way, or be cups. From every guess the flow goes on to a steady train, and Newton's method
looks for one with those taken out that are known already. What it finds counts if it is there at a
higher degree, too, as low degrees have trains of their own. Each further one comes with its
distance from the known one and with the growth rate of its axisymmetric disturbances: one that
grows is a train that nobody will see.

Scaling. Lengths in r0, velocities in U, rates in U/r0; tube of diameter 6, packing 0.2, degree 8.

Reference. P. E. Farrell, A. Birkisson and S. W. Funke, SIAM J. Sci. Comput. 37, A2026 (2015).

Run time. About half a minute on two cores.

Command. ``python examples/search.py [FOLDER]``; the table goes to standard output, a picture to
out/search unless told otherwise. ``celltrain search`` does the same for any case.
"""

import sys
from pathlib import Path

from rich.console import Console

from celltrain import Train, show, steady
from celltrain.cli.progress import Reporter
from celltrain.continuation import SearchTry, search_trains
from celltrain.pictures import draw_search

TRAIN = Train(diameter=6, packing=0.2, cells=1, degree=8)


def main(folder: Path = Path("out/search")) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    output, done = Console(), list[SearchTry]()
    with Reporter() as reporter:
        known = steady(TRAIN, progress=reporter.iteration)

        def tell(each: SearchTry) -> None:
            done.append(each)
            reporter.log(f"try {len(done)}: from {each.guess} by {each.way}: {each.outcome}")

        found = search_trains(known, progress=tell)
    show(found, output)
    draw_search(found).savefig(folder / "search.png")
    output.print(str(folder / "search.png"), highlight=False)


if __name__ == "__main__":
    main(*(Path(argument) for argument in sys.argv[1:2]))
