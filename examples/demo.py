"""Two trains of red blood cells in one tube, one unstable and one not; and how disorder grows.

Physics. Eight red blood cells follow each other through a straight tube, so narrow that they form a
bullet each and a single file together. Is that file stable? At a packing phi = r0 N/L of 0.2 (cells
five radii apart) it is not: the cells tilt, all alike. At 0.5 (two radii apart) nothing grows. The
second steady train is reached from the first one by continuation in the packing. Then two cells at
packing 0.2, at the degree that simulations have, are disturbed by their fastest mode and followed
in time: their tilt grows as the linear theory says while it is small.

Scaling. Lengths in r0 (radius of the sphere of a cell's volume), velocities in U (mean velocity in
the tube), viscosities in mu (plasma); so rates in U/r0. The tube's diameter is 6 r0, viscosities
inside and outside are equal, and the membrane is a red blood cell's at U = 2.875 mm/s.

Reference. S. H. Bryngelson and J. B. Freund, Global stability of flowing red blood cell trains,
Phys. Rev. Fluids 3, 073101 (2018): Figs. 4, 5, 6 and 11. Rates as that paper prints them are ten
times those in U/r0; see celltrain.parameters.units.

Run time. Two minutes on two cores, nearly all of it the simulation and its compilation.

Command. ``make demo``, or ``python examples/demo.py [FOLDER]``; results and pictures go to
out/demo unless told otherwise.
"""

import sys
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from celltrain import (
    Base,
    Run,
    Stability,
    Train,
    draw_all,
    evolve,
    paper_units,
    save,
    show,
    stability,
)
from celltrain.cli.progress import Reporter
from celltrain.evolution import Leading
from celltrain.stability.verdict import verdict

# Of two cells, so that it takes a minute or two; the breakup of eight takes hours.
SIMULATED = Train(diameter=6, packing=0.2, cells=2, degree=12)
AMPLITUDE, UNTIL = 0.05, 240.0
# The growth is compared until the disturbance is this large (r0).
SMALL = 0.1


def compute(train: Train, start: Base | None) -> Stability:
    """The steady train and its stability, with progress on standard error."""
    with Reporter() as reporter:
        reporter.log(f"packing {train.packing:g}: steady train, then its linear dynamics")
        return stability(
            train,
            start=start,
            progress=reporter.share,
            iteration=reporter.iteration,
            tell=reporter.log,
        )


def keep(result: Stability, folder: Path) -> list[Path]:
    """Save a result and its pictures; returns the files."""
    with Reporter() as reporter:
        reporter.log(f"pictures for packing {result.base.train.packing:g}")
        folder.mkdir(parents=True, exist_ok=True)
        return [save(result, folder / "result.nc"), *draw_all(result, folder)]


def simulate(path: Path) -> Run:
    """A disturbed train in time, in a file that is whole at every moment."""
    with Reporter() as reporter:
        reporter.log(f"simulation of {SIMULATED.cells} cells: steady train, linear dynamics, march")
        start = stability(SIMULATED, azimuthal_numbers=(0, 1, 2), estimate_error=False)
    path.parent.mkdir(parents=True, exist_ok=True)
    with Reporter() as progress:
        return evolve(
            start,
            Leading(AMPLITUDE),
            until=UNTIL,
            every=5.0,
            path=path,
            overwrite=True,
            progress=progress.step,
        )


def comparison(sparse: Stability, dense: Stability, run: Run) -> Table:
    """What the paper states, beside what was found."""
    table = Table("phi", "the paper says", "we find", title="Beside the paper", show_lines=True)
    table.title_justify = table.caption_justify = "left"
    table.title_style = "bold"
    table.caption = "alpha as the paper prints it: in U*/r0 with U* = U/10"
    for train, statement, found in (
        (sparse.base.train, "unstable, alpha ~ 0.1", _growth(sparse)),
        (sparse.base.train, "uniform tilt (m = 1, q = 0)", _pattern(sparse)),
        (dense.base.train, "marginally stable, alpha < 0.001", _growth(dense)),
        (run.train, "simulations match exp(A t) v (Fig. 4)", _beside_theory(run)),
    ):
        table.add_row(f"{train.packing:g}", statement, found)
    return table


def _growth(result: Stability) -> str:
    alpha = paper_units.rate(result.spectral_abscissa)
    return f"{verdict(result).split(':')[0]}, alpha = {alpha:.2g}"


def _pattern(result: Stability) -> str:
    mode, cells = result.leading, result.base.train.cells
    waves = "q = 0" if mode.wave_number == 0 else f"q = 2 pi {mode.wave_number}/{cells}"
    tilt = "tilt" if mode.azimuthal_number == 1 else "no tilt"
    return f"{tilt} (m = {mode.azimuthal_number}, {waves})"


def _beside_theory(run: Run) -> str:
    eps, linear = run.frames["eps"], run.frames["eps_linear"]
    small = eps < SMALL
    off = float(np.abs(eps / linear - 1.0)[small].max())
    return (
        f"within {100.0 * off:.2g} % up to eps = {eps[small].max():.2g} r0 (N = {run.train.cells})"
    )


def main(folder: Path = Path("out/demo")) -> None:
    output = Console()
    train = Train(diameter=6, packing=0.2, cells=8)
    sparse = compute(train, None)
    dense = compute(train.changed(packing=0.5), sparse.base)
    simulation = folder / "simulation"
    run = simulate(simulation / "run.nc")
    for result in (sparse, dense):
        show(result, output)
        output.print()
    show(run, output)
    output.print(comparison(sparse, dense, run))
    for result in (sparse, dense):
        place = folder / f"phi-{result.base.train.packing:g}"
        for path in keep(result, place):
            output.print(str(path), highlight=False, soft_wrap=True)
    for path in draw_all(run, simulation):
        output.print(str(path), highlight=False, soft_wrap=True)


if __name__ == "__main__":
    main(*(Path(argument) for argument in sys.argv[1:2]))
