"""How far from normal a train's dynamics is: pseudospectra, the Kreiss constant, adjoint modes.

Physics. The eigenvalues say what grows in the end; the levels of the resolvent around them say how
much they would move if the dynamics were a little different, and how much disturbances grow
meanwhile. The Kreiss constant K bounds that from below once the growth of the leading mode is taken
out. For the unstable tilt of a sparse train, K is that mode's condition number: best excited by the
adjoint mode, a disturbance nine times smaller than the tilt that it becomes. Its eigenvalue is made
at the nose of the cell.

Scaling. Lengths in r0, velocities in U, rates in U/r0; tube of diameter 6, packing 0.2, eight
cells.

Reference. Trefethen and Embree, Spectra and Pseudospectra (2005), chapters 14, 18 and 52; the case
is from Bryngelson and Freund, Phys. Rev. Fluids 3, 073101 (2018).

Run time. About a minute on two cores, the first time some more for compilation.

Command. ``python examples/pseudospectrum.py [FOLDER]``; the table goes to standard output, pictures
to out/pseudospectrum unless told otherwise.
"""

import sys
from pathlib import Path

import numpy as np

from celltrain import Stability, Train, stability, steady
from celltrain.cli.progress import Reporter
from celltrain.pictures import draw_pseudospectrum, draw_structural_sensitivity
from celltrain.stability import (
    PaperNorm,
    condition_number,
    normed_blocks,
    propagator_norm,
    pseudospectrum,
    receptivity,
    structural_sensitivity,
)

TIMES = np.concatenate([np.geomspace(1e-3, 1e3, 80), [1e4]])
HEAD = ("m", "j", "alpha", "eta", "K", "max growth")


def main(folder: Path = Path("out/pseudospectrum")) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    with Reporter() as reporter:
        train = Train(diameter=6, packing=0.2, cells=8, degree=12)
        base = steady(train, progress=reporter.iteration)
        result = stability(
            base, azimuthal_numbers=range(4), estimate_error=False, progress=reporter.share
        )
    blocks = normed_blocks(result, PaperNorm())
    print("".join(f"{name:>12}" for name in HEAD))
    for m in result.azimuthal_numbers:
        for j in (0, 4):
            found = pseudospectrum(result, m, j)
            matrix = blocks[m, j].matrix
            shifted = matrix - found.spectral_abscissa * np.eye(len(matrix))
            largest = propagator_norm(shifted, TIMES).max()
            rates = f"{found.spectral_abscissa:12.5f}{found.numerical_abscissa:12.4f}"
            print(f"{m:12d}{j:12d}{rates}{found.kreiss.constant:12.4f}{largest:12.4f}", flush=True)
            draw_pseudospectrum(found).savefig(folder / f"pseudospectrum-m{m}-j{j}.png")
    leading = result.leading
    place = structural_sensitivity(result, leading)
    print(
        f"leading mode: growth rate {leading.growth_rate:.5f}, condition number"
        f" {condition_number(result, leading, norm=PaperNorm()):.4f} (paper's norm),"
        f" {condition_number(result, leading):.4f} (orthonormal)"
    )
    at = np.degrees(place.theta[place.sensitivity.argmax()])
    print(f"structural sensitivity: integral {place.integral:.4f}, largest at theta = {at:.1f}")
    for name, shapes in (("itself", result.shape(leading)), ("v_eta", result.transient_shape())):
        # Both have the same size.
        print(f"amplitude of the leading mode in {name}: {receptivity_of(result, shapes):.4f}")
    draw_structural_sensitivity(place).savefig(folder / "structural_sensitivity.png")
    print(folder / "structural_sensitivity.png")


def receptivity_of(result: Stability, shapes: np.ndarray) -> float:
    """How much of the leading mode a disturbance excites, relative to the disturbance."""
    size = np.linalg.norm(shapes) / np.sqrt(len(shapes))
    return abs(receptivity(result, result.leading, shapes)) / float(size)


if __name__ == "__main__":
    main(*(Path(argument) for argument in sys.argv[1:2]))
