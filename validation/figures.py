"""The paper's figures at its resolution and converged: kept data, pictures, and statements.

What is kept in docs/validation/data is drawn and checked anew each time. What is not there is
computed: figures that are no studies here, the studies by `celltrain paper FIGURE`, which may be
interrupted; `--results FOLDER` takes what that has left in FOLDER.
"""

import argparse
import subprocess
import sys
from pathlib import Path

import numpy as np
import xarray as xr
from page import FOLDER, Page

from celltrain import __version__
from celltrain.paper import FIGURES, PaperFigure
from celltrain.paper.comparison import compared, comparison_table
from celltrain.paper.evidence import ENDINGS
from celltrain.paper.resolutions import CONVERGED, PAPER, Resolutions
from celltrain.paper.trains import PAPER_DEGREE
from celltrain.results import write_dataset

DATA = FOLDER / "data"
#: What the figures show.
TITLES = {
    "fig3": "Fig. 3: spectrum of two cells",
    "fig4": "Fig. 4: growth at first, small",
    "fig5": "Figs. 5, 15 and 18: steady trains",
    "fig6": "Fig. 6: growth rate over diameter and packing",
    "fig7": "Fig. 7: streamlines between cells, D = 6",
    "fig8": "Fig. 8: initial growth rate over diameter and packing",
    "fig9": "Fig. 9: growth at first of a tenth of r0",
    "fig10": "Fig. 10: spectra of disturbances, D = 10, packing 0.7",
    "fig11": "Fig. 11: growth of the mode and of displaced cells, D = 10",
    "fig13": "Fig. 13: viscosity ratio and packing",
    "fig14": "Fig. 14: viscosity ratio",
    "fig16": "Fig. 16: capillary number",
    "fig17": "Fig. 17: shapes at rest",
    "fig19": "Fig. 19: reduced volume",
    "fig20": "Fig. 20: growth without near neighbours, D = 8",
    "table1": "Table I: strain energy of disturbances",
}
DEGREES = {CONVERGED: None, PAPER: PAPER_DEGREE}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of this study."""
    parser.add_argument(
        "--results",
        type=Path,
        help="folder with what `celltrain paper` has computed: its folders paper-STUDY and"
        " paper-STUDY-degree-12 are taken for the study figures",
    )


def study(work: Path, results: Path | None) -> None:
    """Draw and check all figures; what they take is computed in the folder `work`."""
    page = Page("figures", "The paper's figures")
    page.text(
        f"""
Every figure at the paper's resolution, M = {PAPER_DEGREE}, and converged to 1 % or 1e-4 U/r0 of
alpha, by `celltrain paper FIGURE`. Lines, with the error where it is known, are converged; open
symbols are M = {PAPER_DEGREE}. Growth rates in the paper's unit U*/r0 with U* = U/10, lengths in
r0. The data are in `data/`, two netCDF files for each study (`STUDY.nc`, `STUDY-degree-12.nc`).
What follows from all of it is [the page on the paper](../paper.md).
"""
    )
    for name, title in TITLES.items():
        figure = FIGURES[name]
        data = {
            resolution: _kept(page, name, figure, resolution, work, results)
            for resolution in ENDINGS
        }
        found = {resolution: figure.findings(each) for resolution, each in data.items()}
        path = FOLDER / f"figures-{name}.png"
        figure.draw(data).savefig(path)
        page.heading(title)
        page.text(_made(data))
        page.parts.append(comparison_table(compared(found[PAPER], found[CONVERGED])).rstrip())
        page.parts.append(f"![{title}]({path.name})\n\n*{title}*")
        page.log(title)
    page.write()


def _kept(
    page: Page, name: str, figure: PaperFigure, resolution: str, work: Path, results: Path | None
) -> xr.Dataset:
    """The data of a figure: what `--results` has, what is kept, or computed now."""
    path = DATA / f"{figure.study}{ENDINGS[resolution]}.nc"
    if results is not None:
        found = results / f"paper-{figure.study}{ENDINGS[resolution]}" / "study.nc"
        if found.is_file():
            write_dataset(read(found), path)
    if not path.is_file() and figure.compute is not None:
        write_dataset(made_with(figure.compute(DEGREES[resolution])), path)
        page.log(f"{name}, {resolution}")
    elif not path.is_file():
        folder = work / f"paper-{figure.study}{ENDINGS[resolution]}"
        command = [sys.executable, "-c", "import sys; from celltrain.cli import main; main()"]
        command += ["paper", name, "--resolution", resolution, "-o", str(folder)]
        subprocess.run(command, check=False)
        write_dataset(read(folder / "study.nc"), path)
    return read(path)


def read(path: Path) -> xr.Dataset:
    """A file's data in memory."""
    with xr.open_dataset(path) as data:
        return data.load()


def made_with(data: xr.Dataset) -> xr.Dataset:
    """Data with the version that made them."""
    return data.assign_attrs(celltrain_version=__version__)


def _made(data: Resolutions) -> str:
    """How many cases there are, which are missing, and how long they took."""
    if "status" not in data[CONVERGED]:
        degrees = [
            np.unique(each["taken_degree"].values)
            for each in (data[CONVERGED],)
            if "taken_degree" in each
        ]
        if not degrees:
            return "Computed in seconds to some minutes."
        low, high = float(degrees[0].min()), float(degrees[0].max())
        taken = f"M = {low:.0f}" if low == high else f"M = {low:.0f} to {high:.0f}"
        return f"Converged at {taken}."
    words = []
    for resolution, each in data.items():
        finished = each["status"].values == "finished"
        minutes = np.nansum(each["case_seconds"].values) / 60.0
        label = "Converged" if resolution == CONVERGED else f"M = {PAPER_DEGREE}"
        words.append(
            f"{label}: {int(finished.sum())} of {finished.size} cases in {minutes:.0f} minutes of"
            " one thread"
        )
        if resolution == CONVERGED:
            degrees = each["taken_degree"].values[finished]
            words[-1] += f", at M = {degrees.min():.0f} to {degrees.max():.0f}"
        if (~finished).any():
            reasons = sorted({str(x).split(":")[0] for x in each["reason"].values[~finished]})
            listed = ", ".join(filter(None, reasons)) or "not computed"
            words[-1] += f" (the others: {listed})"
        if "comment" in each.attrs:
            words[-1] += f" ({each.attrs['comment']})"
    residual = max(float(each["residual"].max()) for each in data.values())
    return "; ".join(words) + f". Largest residual of a steady train {residual:.0e} U."
