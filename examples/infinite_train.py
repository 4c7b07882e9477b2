"""A train without end: which wave of cells grows fastest, not which of those that N cells allow.

Physics. Eight cells with periodic ends can only tilt in waves of 8, 4, 8/3 or 2 cells, or all
alike. An infinite train has a growth rate alpha_m(q) for any phase q from one cell to the next. At
a packing of 0.2 it is largest for q = 0; at 0.5 nothing grows, and the slowest disturbance is a
long wave of the cells' spacing. As q goes to 0 the dynamics goes to that of all cells alike.

Scaling. Lengths in r0, velocities in U, rates in U/r0; tube of diameter 6. q in radians per cell.

Reference. Bryngelson and Freund, Phys. Rev. Fluids 3, 073101 (2018), have trains of eight and
sixteen cells (Fig. 6).

Run time. Ten seconds, the first time some more for compilation.

Command. ``python examples/infinite_train.py [FOLDER]``; curves and pictures go to
out/infinite_train unless told otherwise. ``celltrain infinite`` does one case.
"""

import sys
from pathlib import Path

from rich.console import Console

from celltrain import Base, Train, save, show
from celltrain.cli.progress import Reporter
from celltrain.pictures import draw_dispersion
from celltrain.stability import distance_to_uniform, infinite_train

SMALL = (0.01, 0.1)


def main(folder: Path = Path("out/infinite_train")) -> None:
    output = Console()
    start: Base | None = None
    folder.mkdir(parents=True, exist_ok=True)
    for packing in (0.2, 0.5):
        train = Train(diameter=6, packing=packing)
        with Reporter() as reporter:
            reporter.log(f"packing {packing:g}")
            result = infinite_train(
                train, start=start, iteration=reporter.iteration, tell=reporter.log
            )
            start = result.base
        show(result, output)
        name = f"phi-{packing:g}"
        save(result, folder / f"{name}.nc")
        path = folder / f"{name}.png"
        draw_dispersion(result).savefig(path)
        output.print(str(path), highlight=False)
        uniform(start, output)


def uniform(base: Base, output: Console) -> None:
    """How far the dynamics of long waves is from that of all cells alike."""
    for m, values in distance_to_uniform(base, SMALL).items():
        words = ", ".join(
            f"{value:.1e} at q = {q:g}" for q, value in zip(SMALL, values, strict=True)
        )
        output.print(f"m = {m}: |A(q) - A(0)|/|A(0)| = {words}", highlight=False)


if __name__ == "__main__":
    main(*(Path(argument) for argument in sys.argv[1:2]))
