"""Two eigenvalues over the strength of the flow (Fig. 16a): they meet, and are complex beyond.

Kept in docs/validation/data/double-point.nc, with the numbers of the paper's own solver from
docs/validation/data/paper-solver.toml beside them; computed anew if the file is not there.
"""

import tomllib

import numpy as np
import xarray as xr
from page import FOLDER, Page, plain_figure

from celltrain import Train, steady
from celltrain.parameters import paper_units
from celltrain.stability.linearise import linear_blocks
from celltrain.stability.neutral import neutral_space
from celltrain.stability.spectrum import growing_eigenvalues

FILE = FOLDER / "data" / "double-point.nc"
SOLVER = FOLDER / "data" / "paper-solver.toml"
DEGREES = (12, 16, 20, 24, 32)
#: Ca as the paper counts it: of its own figure, and close to where the eigenvalues meet.
CAPILLARY = (0.4, 0.5, 0.66, 0.8, 1.0, 1.3, 1.6, 2.0, 2.2, 2.4, 2.6, 2.8, 3.0, 3.3, 3.6, 4.0)
STRONG = (5.0, 6.0, 8.0, 10.0, 14.0, 20.5)
TILT = 1


def compute(page: Page) -> xr.Dataset:
    """The two least stable eigenvalues of the tilt alike in all cells, D = 8, packing 0.2."""
    capillary = (*CAPILLARY, *STRONG)
    found = np.full((2, len(DEGREES), len(capillary), 2), np.nan)
    for row, degree in enumerate(DEGREES):
        base = None
        for column, each in enumerate(capillary):
            train = Train(
                diameter=8,
                packing=0.2,
                cells=1,
                degree=degree,
                capillary_number=paper_units.capillary_number_from_paper(each),
            )
            base = steady(train, start=base, estimate_error=False)
            [block] = linear_blocks(base, [0.0], [TILT])[TILT]
            pair = growing_eigenvalues(block, neutral_space(base, TILT, 0))[:2]
            found[:, row, column] = pair.real, pair.imag
        page.log(f"degree {degree}")
    dims = ("degree", "Ca", "eigenvalue")
    return xr.Dataset(
        {
            name: (dims, values, {"units": "U/r0", "long_name": f"{name} part of the eigenvalue"})
            for name, values in zip(("real", "imaginary"), found, strict=True)
        },
        coords={"degree": list(DEGREES), "Ca": list(capillary), "eigenvalue": [1, 2]},
        attrs={
            "title": "the two least stable eigenvalues of m = 1, q = 0, D = 8, packing 0.2",
            "comment": "Ca as the paper counts it, 0.8 mu U/Es; all moduli change alike",
        },
    )


def meeting(data: xr.Dataset, degree: int) -> tuple[float, float]:
    """Between which Ca two real eigenvalues become a complex pair for good."""
    real = (data["imaginary"].sel(degree=degree, eigenvalue=1) == 0.0).values
    last = int(np.flatnonzero(real)[-1])
    capillary = data["Ca"].values
    return float(capillary[last]), float(capillary[min(last + 1, len(capillary) - 1)])


def study() -> None:
    page = Page("double_point", "Two eigenvalues over the strength of the flow (Fig. 16a)")
    data = page.kept(FILE, compute)
    solver = tomllib.loads(SOLVER.read_text())
    page.text(
        """
D = 8, packing 0.2, viscosity ratio 1: the two least stable modes of m = 1 that are alike in all
cells, over Ca as the paper counts it, at several degrees. Rates in U/r0. The paper: alpha falls by
a factor of two from Ca = 1 to 10.
"""
    )
    page.table(
        ("Ca", *(f"M = {degree}" for degree in DEGREES)),
        [
            (f"{capillary:g}", *(_pair(data.sel(Ca=capillary, degree=each)) for each in DEGREES))
            for capillary in data["Ca"].values
        ],
    )
    page.text(
        "Two real eigenvalues meet and become a complex pair, between Ca = "
        + "; ".join(
            f"{first:g} and {last:g} (M = {degree})"
            for degree in DEGREES
            for first, last in [meeting(data, degree)]
        )
        + ". Close to a double point an eigenvalue is as the square root of an error, which is why"
        " low degrees differ most there."
    )
    page.heading("The paper's own solver")
    page.text(
        f"""
{solver["source"]} It finds the growth to fall from Ca = 1 to 10 at M = 12 as the paper does, and at
M = 20 the complex pair that hardly grows.
"""
    )
    page.table(
        ("Ca", "M", "first", "second"),
        [
            (each["Ca"], each["degree"], *(_number(*pair) for pair in each["eigenvalues"]))
            for each in solver["flow_strength"]
        ],
    )
    _figure(page, data, solver)
    page.write()


def _pair(at: xr.Dataset) -> str:
    first, second = (
        _number(float(at["real"][place]), float(at["imaginary"][place])) for place in (0, 1)
    )
    return first if float(at["imaginary"][0]) != 0.0 else f"{first}, {second}"


def _number(real: float, imaginary: float) -> str:
    return f"{real:+.5f}" + (f" +- {abs(imaginary):.5f}i" if imaginary else "")


def _figure(page: Page, data: xr.Dataset, solver: dict) -> None:
    figure = plain_figure(8.6, 3.6)
    left, right = figure.subplots(1, 2)
    for degree, shade in zip(DEGREES, np.linspace(0.8, 0.0, len(DEGREES)), strict=True):
        at = data.sel(degree=degree)
        for place in (0, 1):
            label = f"M = {degree}" if place == 0 else None
            left.plot(at["Ca"], at["real"][:, place], ".-", color=str(shade), ms=3, label=label)
        right.plot(at["Ca"], abs(at["imaginary"][:, 0]), ".-", color=str(shade), ms=3)
    for degree, marker in ((12, "o"), (16, "s"), (20, "^")):
        points = [each for each in solver["flow_strength"] if each["degree"] == degree]
        for place in range(2):
            values = [(each["Ca"], *each["eigenvalues"][place]) for each in points]
            capillary, real, imaginary = np.array(values).T
            style = {"color": "#D55E00", "fillstyle": "none", "linestyle": "none"}
            label = f"RBC3D, M = {degree}" if place == 0 else None
            left.plot(capillary, real, marker, label=label, **style)
            if place == 0:
                right.plot(capillary, abs(imaginary), marker, **style)
    left.set(xscale="log", xlabel="Ca", ylabel=r"$\mathrm{Re}\,\lambda$ ($U/r_0$)")
    right.set(xscale="log", xlabel="Ca", ylabel=r"$|\mathrm{Im}\,\lambda|$ ($U/r_0$)")
    left.axhline(0.0, color="0.7", linewidth=0.6, zorder=0)
    left.legend(fontsize=6.5, frameon=False)
    page.figure(figure, "The two least stable eigenvalues, by degree, and those of RBC3D")
