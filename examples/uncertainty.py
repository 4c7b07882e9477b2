"""Cells differ: how much that makes of a train's growth rate, and which parameter it comes from.

Physics. Red cells of one person differ in volume by about 12 % and in the moduli of their
membranes by about 30 %. Trains of 384 kinds of equal cells, drawn from these distributions, say how
the growth rate, the velocity and the apparent viscosity are distributed, and Sobol indices how much
of each variance goes when one parameter is known. Beside them stands what the derivatives at the
means give.

Scaling. Lengths in r0, velocities in U, rates in U/r0, moduli in mu U; tube of diameter 6, packing
0.2, eight cells. The volume is that at constant area (the reduced volume).

Reference. The train of Bryngelson and Freund, Phys. Rev. Fluids 3, 073101 (2018), Figs. 5 and 6, at
the degree of the paper, 12; the distributions are not in the paper.

Run time. Half a minute on two cores; killed, it goes on when run again.

Command. ``python examples/uncertainty.py [FOLDER]``; the report goes to standard output, pictures
and data to out/uncertainty-example unless told otherwise. ``celltrain sweep`` does the same with a
file.
"""

import sys
from pathlib import Path

from celltrain import draw_all, save, stability
from celltrain.stability import parameter_sensitivities
from celltrain.study import (
    SampledStudy,
    StudyProgress,
    collect_sample,
    local_workers,
    make_sampled_study,
    run_sample,
)

MODULI = ("shear_modulus", "dilatation_modulus", "bending_modulus")
STUDY = {
    "title": "cells that differ",
    "case": {"diameter": 6, "packing": 0.2, "cells": 8, "degree": 12},
    "distributions": {
        "reduced_volume": {"normal": {"relative_deviation": 0.12}},
        **{name: {"lognormal": {"relative_deviation": 0.3}} for name in MODULI},
    },
    "sample": {"points": 64, "seed": 0},
}


def told(progress: StudyProgress) -> None:
    print(f"\r{progress.finished} of {progress.total} trains", end="", file=sys.stderr)


def by_derivatives(study: SampledStudy) -> dict[str, float]:
    """The part of the variance of alpha from each parameter, to first order."""
    entries = parameter_sensitivities(stability(study.central, estimate_error=False)).entries
    squares = {
        each.name: (entries[each.name].growth_rate * each.standard_deviation) ** 2
        for each in study.distributions
    }
    return {name: float(square / sum(squares.values())) for name, square in squares.items()}


def main(folder: Path = Path("out/uncertainty-example")) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    study = make_sampled_study(STUDY)
    with local_workers() as workers:
        found = run_sample(study, folder.absolute(), workers.executor, workers.slots, progress=told)
    print(file=sys.stderr)
    result = collect_sample(study, found)
    save(result, folder / "study.nc")
    draw_all(result, folder)
    print(result.table())
    indices = result.data["first_order"].sel(output="spectral_abscissa")
    print("part of the variance of alpha:       from trains   from derivatives")
    for name, linear in by_derivatives(study).items():
        print(f"{name:<35}{float(indices.sel(parameter=name)):>13.2f}{linear:>19.2f}")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
