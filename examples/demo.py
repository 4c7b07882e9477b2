"""Two trains of red blood cells in one tube: one that breaks up, and one that stays.

Physics. Eight red blood cells follow each other through a straight tube, so narrow that they form a
bullet each and a single file together. Is that file stable? At a packing phi = r0 N/L of 0.2 (cells
five radii apart) it is not: the cells tilt, all alike. At 0.5 (two radii apart) nothing grows. The
second steady train is reached from the first one by continuation in the packing.

Scaling. Lengths in r0 (radius of the sphere of a cell's volume), velocities in U (mean velocity in
the tube), viscosities in mu (plasma); so rates in U/r0. The tube's diameter is 6 r0, viscosities
inside and outside are equal, and the membrane is a red blood cell's at U = 2.875 mm/s.

Reference. S. H. Bryngelson and J. B. Freund, Global stability of flowing red blood cell trains,
Phys. Rev. Fluids 3, 073101 (2018): Figs. 5 and 6. Rates as that paper prints them are ten times
those in U/r0; see celltrain.parameters.units.

Run time. One to two minutes on two cores, the first time some more for compilation.

Command. ``make demo``, or ``python examples/demo.py [FOLDER]``; results and pictures go to
out/demo unless told otherwise.
"""

import sys
from pathlib import Path

from rich.console import Console
from rich.table import Table

from celltrain import Base, Stability, Train, paper_units, print_report, save, stability, steady
from celltrain.cli.progress import Reporter
from celltrain.pictures import plot_all
from celltrain.results import verdict


def compute(train: Train, start: Base | None, errors: Console) -> Stability:
    """The steady train and its stability, with progress on standard error."""
    with Reporter(errors, quiet=False) as reporter:
        reporter.log(f"packing {train.packing:g}: steady train, then its linear dynamics")
        base = steady(train, start=start, progress=reporter.iteration)
        return stability(base, progress=reporter.share)


def keep(result: Stability, folder: Path, errors: Console) -> list[Path]:
    """Save a result and its pictures; returns the files."""
    with Reporter(errors, quiet=False) as reporter:
        reporter.log(f"pictures for packing {result.base.train.packing:g}")
        folder.mkdir(parents=True, exist_ok=True)
        return [save(result, folder / "result.nc"), *plot_all(result, folder)]


def comparison(sparse: Stability, dense: Stability) -> Table:
    """What the paper states, beside what was found."""
    table = Table("phi", "the paper says", "we find", title="Beside the paper", show_lines=True)
    table.title_justify = table.caption_justify = "left"
    table.title_style = "bold"
    table.caption = "alpha as the paper prints it: in U*/r0 with U* = U/10"
    for result, statement, found in (
        (sparse, "unstable, alpha ~ 0.1", _growth(sparse)),
        (sparse, "uniform tilt (m = 1, q = 0)", _pattern(sparse)),
        (dense, "marginally stable, alpha < 0.001", _growth(dense)),
    ):
        table.add_row(f"{result.base.train.packing:g}", statement, found)
    return table


def _growth(result: Stability) -> str:
    alpha = paper_units.rate(result.spectral_abscissa)
    return f"{verdict(result).split(':')[0]}, alpha = {alpha:.2g}"


def _pattern(result: Stability) -> str:
    mode, cells = result.leading, result.base.train.cells
    waves = "q = 0" if mode.wave_number == 0 else f"q = 2 pi {mode.wave_number}/{cells}"
    tilt = "tilt" if mode.azimuthal_number == 1 else "no tilt"
    return f"{tilt} (m = {mode.azimuthal_number}, {waves})"


def main(folder: Path = Path("out/demo")) -> None:
    errors, output = Console(stderr=True), Console()
    sparse = compute(Train(diameter=6, packing=0.2, cells=8), None, errors)
    dense = compute(sparse.base.train.changed(packing=0.5), sparse.base, errors)
    for result in (sparse, dense):
        print_report(result, output)
        output.print()
    output.print(comparison(sparse, dense))
    for result in (sparse, dense):
        place = folder / f"phi-{result.base.train.packing:g}"
        for path in keep(result, place, errors):
            output.print(str(path), highlight=False, soft_wrap=True)


if __name__ == "__main__":
    main(*(Path(argument) for argument in sys.argv[1:2]))
