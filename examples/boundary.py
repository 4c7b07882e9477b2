"""How dense a train must be to keep its order: the curve alpha(D, packing) = 0, and its certainty.

Physics. In a sparse train all cells tilt alike; where cells are close, the tilt decays. The packing
at which it neither grows nor decays depends on the tube's diameter. The curve is followed with the
exact gradient of the growth rate, not found by scanning maps. Beside it, error bars say whether the
sign of the growth rate is known.

Scaling. Lengths in r0, velocities in U, rates in U/r0; q = 0, m = 1, tubes of diameter 6 and wider.

Reference. Bryngelson and Freund, Phys. Rev. Fluids 3, 073101 (2018), Fig. 6, where the marginal
region begins at a packing of 0.4. The curve itself is not in the paper.

Run time. About ten seconds on two cores.

Command. ``python examples/boundary.py [FOLDER]``; the table goes to standard output, pictures to
out/boundary unless told otherwise. Interrupted, it has printed what it found.
"""

import sys
from pathlib import Path

from rich.console import Console

from celltrain import Base, Train, stability, steady
from celltrain.cli.progress import Reporter
from celltrain.continuation import BoundaryPoint, Steps, stability_boundary
from celltrain.pictures import draw_error_bars, draw_stability_boundary
from celltrain.stability import with_error_bars

DEGREE = 12
# A train close to the boundary, in which the tilt still grows.
PACKING = 0.388
MODES = 3


def main(folder: Path = Path("out/boundary")) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    output = Console()
    train = Train(diameter=6, packing=PACKING, cells=2, degree=DEGREE)
    with Reporter() as reporter:
        start = steady(train, progress=reporter.iteration)

    def show(point: BoundaryPoint) -> None:
        output.print(
            f"D = {point.diameter:.4f} r0, packing {point.packing:.4f}, gap {point.base.gap:.3f}",
            highlight=False,
        )

    found = stability_boundary(
        start,
        azimuthal_number=1,
        phase=0.0,
        most_points=4,
        steps=Steps(first=0.06, largest=0.12, tolerance=1e-6),
        progress=show,
    )
    output.print(found.ending.message)
    pictures = [folder / "boundary.png"]
    draw_stability_boundary({"all cells alike": found}).savefig(pictures[0])
    pictures.append(certainty(start, folder, output))
    for path in pictures:
        output.print(str(path), highlight=False)


def certainty(base: Base, folder: Path, output: Console) -> Path:
    """Error bars of the leading growth rates next to the boundary."""
    result = stability(base, azimuthal_numbers=(0, 1), estimate_error=False)
    result = with_error_bars(result, count=MODES)
    for bar in result.error_bars:
        output.print(
            f"m = {bar.mode.azimuthal_number}, j = {bar.mode.wave_number}: growth rate"
            f" {bar.mode.growth_rate:+.5f}, error {bar.total:.5f} U/r0",
            highlight=False,
        )
    path = folder / "error_bars.png"
    draw_error_bars(result).savefig(path)
    return path


if __name__ == "__main__":
    main(*(Path(argument) for argument in sys.argv[1:2]))
